#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Whatever is cited has its entry in docs/references.md and every entry is cited; tests that the docs name exist.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
complaints=()

entries=$(grep -oE '^- \*\*[A-Z0-9-]+\*\*' docs/references.md | tr -d '* ' | sed 's/^-//' | sort -u)
cited=$(grep -rhoE --include='*.?pp' --include='*.md' --exclude=references.md '\[[A-Z][A-Z-]+[0-9]{2}\b[^]]*\]' apps bench docs libs tests |
  grep -oE '\b[A-Z][A-Z-]+[0-9]{2}\b' | sort -u)
for key in $(comm -13 <(echo "$entries") <(echo "$cited")); do complaints+=("cited, but not in docs/references.md: $key"); done
for key in $(comm -23 <(echo "$entries") <(echo "$cited")); do complaints+=("in docs/references.md, but cited nowhere: $key"); done
while IFS= read -r line; do complaints+=("cite by key: $line"); done < <(
  grep -rnE --include='*.?pp' '[A-Z][a-z]+( et al\.?| (and|,) [A-Z][a-z]+)*,? \(?(19|20)[0-9]{2}\b' apps bench libs tests || true)

for name in $(grep -rhoE '`[A-Z][A-Za-z0-9]*\.[A-Z][A-Za-z0-9]*`' docs ./*.md | tr -d '`' | sort -u); do
  grep -rqE "TEST(_F|_P)?\(${name%.*}, ${name#*.}\)|add_test\(NAME ${name//./[.]}( |$)" tests || complaints+=("no such test: $name")
done

((${#complaints[@]} == 0)) || { printf '%s\n' "${complaints[@]}"; exit 1; }
