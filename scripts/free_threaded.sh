#!/usr/bin/env bash
# Tests the Python package in CPython 3.14 without its global lock (GIL), and measures it there.
#
#   scripts/free_threaded.sh [pytest option ...]
#
# Debian has no package of this Python. So it is built of Debian's source of python3.14, once; then the wheel for it. The
# tests are those that need no cv2. Each of those under load takes a minute, or as many seconds as
# AQORB_LOAD_SECONDS says. At the end it prints the rates of scripts/performance.sh collection.
#
# Installs the Debian packages it needs; pip fetches the rest.
source "$(dirname "$0")/common.sh"

need build wheel
free_threaded_python

say "The wheel"
venv=$BUILD/venv/free-threaded wheels=$BUILD/wheels/free-threaded
rm -rf "$wheels"
PYTHON=$FREE_THREADED environment "$venv" numpy pytest
(cd "$ROOT" && "$venv/bin/pip" wheel -q --no-deps --wheel-dir "$wheels" .)
"$venv/bin/pip" install -q "$wheels"/*.whl

say "Tests"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for test in batch free_threading without_cv2; do cp "$ROOT/bindings/python/test/test_$test.py" "$folder"; done
cp "$ROOT/bindings/python/test/conftest.py" "$folder"
(cd "$folder" && AQORB_LOAD_SECONDS=${AQORB_LOAD_SECONDS:-60} PYTHONDONTWRITEBYTECODE=1 \
    "$venv/bin/python" -X faulthandler -m pytest -q -p no:cacheprovider "$@")

say "Rates"
mkdir -p "$BUILD/performance/free-threaded"
OPENCV_TEST_DATA_PATH='' "$venv/bin/python" "$ROOT/tools/profile/collection.py" \
    >"$BUILD/performance/free-threaded/collection.csv"
need report
/usr/bin/python3 "$ROOT/tools/report/report.py" collection "$BUILD/performance/free-threaded"
