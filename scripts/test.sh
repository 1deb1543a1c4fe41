#!/usr/bin/env bash
# Builds the module against the installed OpenCV and runs all its tests.
#
#   scripts/test.sh [CMake option...]
#
# Installs the Debian packages it needs. Tests that need images of opencv_extra are skipped unless
# OPENCV_TEST_DATA_PATH names its testdata folder.
source "$(dirname "$0")/common.sh"

need build-essential cmake libopencv-dev libgtest-dev xvfb xdotool  # the last two for the sample live

configure "$BUILD/release" -DAQORB_BUILD_TESTS=ON "$@"
build "$BUILD/release"
run_tests "$BUILD/release"
