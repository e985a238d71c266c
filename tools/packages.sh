# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# Sourced by ./crease and ./test. need_packages ROOT KIND...: installs what packages.txt lists and this machine lacks.

missing_packages() {
  local root=$1 kind name wanted=() installed
  shift
  for kind in "$@"; do
    mapfile -t -O "${#wanted[@]}" wanted < <(awk -v kind="$kind" '$1 == kind { print $2 }' "$root/packages.txt")
  done
  installed=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' "${wanted[@]}" 2> /dev/null) || true # some are unknown
  for name in "${wanted[@]}"; do
    grep -qxF "$name installed" <<< "$installed" || echo "$name"
  done
}

need_packages() {
  command -v dpkg-query > /dev/null || return 0 # another system: the build will say what it misses
  local missing sudo=() log
  mapfile -t missing < <(missing_packages "$@")
  ((${#missing[@]})) || return 0

  local by_hand="apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
  if ((EUID != 0)); then
    command -v sudo > /dev/null || { echo "crease: please run as root: $by_hand" >&2; return 3; }
    sudo=(sudo)
  fi
  echo "crease: installing ${missing[*]}" >&2
  log=$(mktemp)
  local apt=("${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=600)
  if ! { "${apt[@]}" update && "${apt[@]}" install -y --no-install-recommends "${missing[@]}"; } > "$log" 2>&1 < /dev/null; then
    cat "$log" >&2
    rm -f "$log"
    echo "crease: could not install them; please see to it as root: $by_hand" >&2
    return 3
  fi
  rm -f "$log"
}
