#!/usr/bin/env bash
# Builds the Python package, runs its tests, those of the Python samples, and the demo.
#
#   scripts/python.sh [pytest option ...]
#
# Installs the Debian packages it needs. The package lies in build/release/python then; programs find it there with
# PYTHONPATH. Tests that need images of opencv_extra are skipped unless OPENCV_TEST_DATA_PATH names its testdata
# folder.
source "$(dirname "$0")/common.sh"

need build-essential cmake libopencv-dev python3-dev pybind11-dev python3-numpy python3-opencv python3-pytest mypy \
    xvfb xdotool  # the last two for the sample live

configure "$BUILD/release" -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON" -DAQORB_BUILD_TESTS=OFF
build "$BUILD/release"
export PYTHONPATH=$BUILD/release/bindings/python PYTHONDONTWRITEBYTECODE=1

say "Tests"
AQORB_BINDING=aqorb "$PYTHON" -m pytest -q -p no:cacheprovider "$@" \
    "$ROOT/modules/aqorb/misc/python/test" "$ROOT/bindings/python/test" "$ROOT/samples/test"

say "The installed package"
prefix=$BUILD/prefix-python
rm -rf "$prefix"
cmake --install "$BUILD/release" --prefix "$prefix" >/dev/null
PYTHONPATH=$(echo "$prefix"/lib/python3*/*-packages) "$PYTHON" -c 'import aqorb; print(aqorb.__file__)'

say "Demo"
opencv_samples
mkdir -p "$BUILD/demo-python"
OPENCV_SAMPLES_DATA_PATH=$OPENCV_SAMPLES "$PYTHON" "$ROOT/samples/aqorb_demo.py" --out="$BUILD/demo-python"
