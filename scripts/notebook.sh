#!/usr/bin/env bash
# Runs the notebook samples/notebook/aqorb.ipynb, and leaves it with its pictures in build/notebook/aqorb.html.
#
#   scripts/notebook.sh WHEEL
#
# WHEEL is the package's, from scripts/wheel.sh, for Debian's python3.
source "$(dirname "$0")/common.sh"

(($# == 1)) || die "name one wheel; --help says more"
need wheel
opencv_samples
wheel=$(realpath "$1")
environment "$BUILD/venv/notebook" ipykernel matplotlib nbconvert "opencv-python-headless==$OPENCV_4" "${wheel}[cli]"
mkdir -p "$BUILD/notebook"
export OPENCV_SAMPLES_DATA_PATH=$OPENCV_SAMPLES PATH=$BUILD/venv/notebook/bin:$PATH
jupyter nbconvert --execute --to html --log-level=WARN --output-dir "$BUILD/notebook" \
    "$ROOT/samples/notebook/aqorb.ipynb"
ls -l "$BUILD/notebook/aqorb.html"
