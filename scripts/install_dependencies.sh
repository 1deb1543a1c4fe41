#!/usr/bin/env bash
# Installs the Debian packages that a kind of work needs, as the other scripts do by themselves.
#
#   scripts/install_dependencies.sh [--list] [GROUP ...]
#
# Without a GROUP it installs the groups build and test. --list installs nothing: it prints the packages of the named
# groups, or of all groups.
source "$(dirname "$0")/common.sh"

list=
if [[ ${1:-} == --list ]]; then list=yes && shift; fi
for group; do
    [[ ${PACKAGES[$group]:-} ]] || die "there is no group $group; there are: ${!PACKAGES[*]}"
done

if [[ $list ]]; then
    (($#)) || mapfile -t groups < <(printf '%s\n' "${!PACKAGES[@]}" | sort)
    for group in "${@:-${groups[@]}}"; do printf '%-10s %s\n' "$group" "${PACKAGES[$group]}"; done
    exit
fi
if (($#)); then need "$@"; else need build test; fi
