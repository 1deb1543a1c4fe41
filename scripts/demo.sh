#!/usr/bin/env bash
# Builds the module and shows what it does beside cv::ORB.
#
#   scripts/demo.sh [IMAGE ...]
#
# Installs the Debian packages it needs. Without images it takes graf1 and graf3, two of OpenCV's samples
# whose homography is known. The pictures go to build/demo.
source "$(dirname "$0")/common.sh"

need build

configure release -DAQORB_BUILD_SAMPLES=ON
build "$BUILD/release" --target aqorb_demo

if (($# == 0)); then
    opencv_samples
    set -- --homography="$OPENCV_SAMPLES/H1to3p.xml" "$OPENCV_SAMPLES/graf1.png" "$OPENCV_SAMPLES/graf3.png"
fi
mkdir -p "$BUILD/demo"
exec "$BUILD/release/samples/aqorb_demo" --out="$BUILD/demo" "$@"
