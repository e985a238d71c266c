#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Objects compiled for one kind of processor define no symbol that the linker may take for all: a weak one could replace
# the copy that every processor runs.
set -euo pipefail
checked=0
for object in "$@"; do
  [[ $object == *_kernels_avx* ]] || continue
  shared=$(nm --demangle "$object" | grep -E ' [VWu] ' || true)
  [[ -z $shared ]] || { printf '%s shares:\n%s\n' "$object" "$shared"; exit 1; }
  checked=$((checked + 1))
done
[[ $(uname -m) != x86_64 || $checked == 2 ]] || { echo "expected two objects of kernels, got $checked"; exit 1; }
