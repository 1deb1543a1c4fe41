#!/usr/bin/env bash
# Builds the Python package, runs its tests, those of the Python samples, and the demo.
#
#   scripts/python.sh [pytest option ...]
#
# Installs the Debian packages it needs. The package lies in build/release/python then; programs find it there with
# PYTHONPATH. Tests that need images of opencv_extra are skipped unless OPENCV_TEST_DATA_PATH names its testdata
# folder.
source "$(dirname "$0")/common.sh"

need build python

configure release -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON"
build "$BUILD/release" --target _aqorb
export PYTHONPATH=$BUILD/release/bindings/python PYTHONDONTWRITEBYTECODE=1

say "Tests"
AQORB_BINDING=aqorb "$PYTHON" -m pytest -q -p no:cacheprovider "$@" \
    "$ROOT/modules/aqorb/misc/python/test" "$ROOT/bindings/python/test" "$ROOT/samples/test"

say "The installed package"
prefix=$BUILD/prefix-python
rm -rf "$prefix"
for component in runtime python; do
    cmake --install "$BUILD/release" --component "$component" --prefix "$prefix" >/dev/null
done
PYTHONPATH=$(echo "$prefix"/lib/python3*/*-packages) "$PYTHON" -c 'import aqorb; print(aqorb.__file__)'

say "Demo"
opencv_samples
mkdir -p "$BUILD/demo-python"
"$PYTHON" "$ROOT/samples/aqorb_demo.py" --out="$BUILD/demo-python" --homography="$OPENCV_SAMPLES/H1to3p.xml" \
    "$OPENCV_SAMPLES/graf1.png" "$OPENCV_SAMPLES/graf3.png"
