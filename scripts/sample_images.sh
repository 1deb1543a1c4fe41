#!/usr/bin/env bash
# Fetches OpenCV's sample images for the samples, the demo and the notebook, and prints their folder.
#
#   scripts/sample_images.sh
#
# They are those of the Debian package opencv-doc (96 MB), which is unpacked to build/cache and not installed. The
# samples find them after
#
#   export OPENCV_SAMPLES_DATA_PATH=$(scripts/sample_images.sh)
#
# Elsewhere than on Debian, name the folder samples/data of OpenCV's source in this variable.
source "$(dirname "$0")/common.sh"

command -v apt-get >/dev/null ||
    die "this is not Debian. Take the folder samples/data of OpenCV's source, and name it in OPENCV_SAMPLES_DATA_PATH"
opencv_samples >&2
echo "$OPENCV_SAMPLES"
