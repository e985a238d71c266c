#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Names every source that clang-format 14 would change: clang-format-14 -i puts it right.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
status=0
while IFS= read -r -d '' file; do
  clang-format-14 --dry-run -Werror "$file" 2> /dev/null || { echo "not formatted: $file"; status=1; }
done < <(find apps bench libs tests \( -name '*.cpp' -o -name '*.hpp' \) -print0 | sort -z)
exit $status
