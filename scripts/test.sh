#!/usr/bin/env bash
# Builds the module against the installed OpenCV and runs all its tests.
#
#   scripts/test.sh [PRESET] [CMake option ...]
#
# PRESET is release, or another one that cmake --list-presets lists: asan and tsan, the sanitizers; fuzz, the fuzz targets
# (-DAQORB_FUZZ_SECONDS=3600 for long); soak, the long run and valgrind, on the build of release.
#
# Installs the Debian packages it needs. Tests that need images of opencv_extra are skipped unless
# OPENCV_TEST_DATA_PATH names its testdata folder. This does the same without installing
# anything: cmake --workflow --preset release
source "$(dirname "$0")/common.sh"

preset=release targets=()
if [[ ${1:-} == [a-z]* ]]; then preset=$1 && shift; fi
folder=$preset
case $preset in
release) need build test ;;
fuzz) need build fuzz ;;
soak) need build test soak && folder=release targets=(--target aqorb_test) ;;
asan | tsan) need build test && targets=(--target aqorb_test) ;;
*) need build test ;;
esac

configure "$folder" "$@"
build "$BUILD/$folder" "${targets[@]}"
run_tests "$preset"
