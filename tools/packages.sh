# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# Sourced by ./crease and ./test. need_packages ROOT KIND...: installs what packages.txt lists and this machine lacks.

need_packages() {
  local root=$1 kind name wanted=() missing=()
  shift
  command -v dpkg-query > /dev/null || return 0 # another system: the build will say what it misses
  for kind in "$@"; do
    mapfile -t -O "${#wanted[@]}" wanted < <(awk -v kind="$kind" '$1 == kind { print $2 }' "$root/packages.txt")
  done
  for name in "${wanted[@]}"; do
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$name" 2> /dev/null) == installed ]] || missing+=("$name")
  done
  ((${#missing[@]})) || return 0

  local apt=(env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0)
  if ((EUID != 0)); then
    if ! command -v sudo > /dev/null; then
      echo "crease: please install as root: apt-get install ${missing[*]}" >&2
      return 3
    fi
    apt=(sudo "${apt[@]}")
  fi
  echo "crease: installing ${missing[*]}" >&2
  local log
  log=$(mktemp)
  if ! { "${apt[@]}" update && "${apt[@]}" install -y --no-install-recommends "${missing[@]}"; } > "$log" 2>&1 < /dev/null; then
    cat "$log" >&2
    rm -f "$log"
    echo "crease: could not install ${missing[*]}" >&2
    return 3
  fi
  rm -f "$log"
}
