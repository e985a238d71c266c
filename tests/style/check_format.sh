#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Names every source that clang-format 14 would change: clang-format-14 -i puts it right.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
mapfile -t files < <(find apps bench libs tests \( -name '*.cpp' -o -name '*.hpp' \) | sort)
complaints=$(clang-format-14 --dry-run -Werror "${files[@]}" 2>&1) && exit 0
names=$(sed -n 's/^\([^ :]*\):[0-9]*:[0-9]*: error:.*/not formatted: \1/p' <<< "$complaints" | sort -u)
echo "${names:-$complaints}"
exit 1
