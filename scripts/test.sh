#!/usr/bin/env bash
# Builds the module against the installed OpenCV and runs all its tests.
#
#   scripts/test.sh [CMake option...]
#
# Installs the Debian packages it needs. Tests that need images of opencv_extra are skipped unless
# OPENCV_TEST_DATA_PATH names its testdata folder. This does the same without installing
# anything: cmake --workflow --preset release
source "$(dirname "$0")/common.sh"

need build test

configure release "$@"
build "$BUILD/release"
run_tests release
