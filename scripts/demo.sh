#!/usr/bin/env bash
# Builds the module and shows what it does beside cv::ORB: a table and two pictures for each pair of images.
#
#   scripts/demo.sh [IMAGE ...]
#   scripts/demo.sh --help
#
# Installs the Debian packages it needs. Without images it takes three pairs of OpenCV's samples (the Debian
# package opencv-doc, fetched, not installed): one where all of the scene is in both images, one with a small object,
# and one from two sides. The pictures go to build/demo.
source "$(dirname "$0")/common.sh"

need build

configure release -DAQORB_BUILD_SAMPLES=ON
build "$BUILD/release" --target aqorb_demo

images=()
for argument; do [[ $argument == -* ]] || images+=("$argument"); done
if ((${#images[@]} == 0)); then opencv_samples && export OPENCV_SAMPLES_DATA_PATH=$OPENCV_SAMPLES; fi
mkdir -p "$BUILD/demo"
export OPENCV_LOG_LEVEL=${OPENCV_LOG_LEVEL:-ERROR}  # else OpenCV warns of each of its pictures that it finds

say "AdaptiveQuadtreeORB beside cv::ORB"
exec "$BUILD/release/samples/aqorb_demo" --out="$BUILD/demo" "$@"
