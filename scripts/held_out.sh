#!/usr/bin/env bash
# Fetches the pairs of images that no default was tuned on, from Debian's and PyPI's packages and from OpenCV's source,
# and lays them out in build/held_out for aqorb_claims. tools/evaluate/held_out.csv lists them.
#
#   scripts/held_out.sh [--estimate]
#
# With --estimate the geometry between the images of each pair is computed again and the list is written. Installs the
# Debian packages it needs.
source "$(dirname "$0")/common.sh"

(($# == 0)) || [[ $* == --estimate ]] || die "unknown argument: $*; see --help"
need python3 python3-pip
if (($#)); then need python3-opencv python3-numpy; fi

opencv_source
held_out_packages
mkdir -p "$BUILD/held_out"
"$PYTHON" "$ROOT/tools/evaluate/held_out.py" "$HELD_OUT_SOURCES" "$BUILD/held_out" "$@"
