#!/usr/bin/env bash
# Builds the Python package and runs sessions of noxfile.py on it, by nox.
#
#   scripts/python.sh [SESSION [OPTION ...]]
#
#   tests       the tests of the package and of the command aqorb; OPTIONs are pytest's. The default
#   asan        the package's tests on an extension module with AddressSanitizer and checks of the GIL
#   hostile     the command is given damaged files, and killed while it writes, often; prints what came of it
#   notebook    pip installs the package and the command, and the notebook of the samples runs there: build/notebook
#   sdist       the source distribution, in build/wheels
#   wheel       the source distribution and the wheel for this system with OpenCV linked in, tested alone and beside
#               pip's cv2; a wheel above MAX_WHEEL_SIZE of noxfile.py is an error
#   beside      the tests of this wheel beside other versions of cv2 and NumPy
#   offline     installed as packagers do it: from the source distribution, where there is no git and no network
#   poses, objects, verdict, reconstruction  scripts/measure.sh poses, objects, verdict, reconstruction
#
# The package is left in build/release/python, where programs find it with PYTHONPATH. Tests that need images of
# opencv_extra are skipped unless OPENCV_TEST_DATA_PATH names its testdata folder.
#
# Installs the Debian packages it needs; pip fetches the rest, and npm pyright.
source "$(dirname "$0")/common.sh"

session=${1:-tests} options=("${@:2}")
case $session in
poses | objects | verdict | reconstruction) session=evaluate options=("$@") ;;
esac
case $session in
tests | hostile | evaluate)
    need build test python python3-matplotlib
    configure release -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON"
    build "$BUILD/release" --target _aqorb
    ;;
asan)
    need build test python
    configure asan-python -DPython_EXECUTABLE="$PYTHON"
    build "$BUILD/asan-python" --target _aqorb
    ;;
notebook)
    need build
    opencv_samples
    export OPENCV_SAMPLES_DATA_PATH=$OPENCV_SAMPLES
    ;;
wheel | beside)
    need build
    command -v npm >/dev/null || need npm  # by which pip's pyright fetches itself
    ;;
*) need build ;;
esac
tools nox
exec "$TOOLS/python" -m nox --noxfile "$ROOT/noxfile.py" --envdir "$BUILD/venv/nox" --session "$session" -- "${options[@]}"
