#!/usr/bin/env bash
# Tests the Python package in CPython 3.14 without its global lock (GIL), and measures it there.
#
#   scripts/free_threaded.sh [pytest option ...]
#
# Debian has no package of this Python. So it is built of Debian's source of python3.14, in build/cache, once; then the
# wheel for it. The tests are those that need no cv2. Each of those under load takes a minute, or as many seconds as
# AQORB_LOAD_SECONDS says. At the end it prints the rates of scripts/performance.sh collection.
#
# Installs the Debian packages it needs; pip fetches the rest.
source "$(dirname "$0")/common.sh"

VERSION=3.14.7
HASH=3b48dac8fb59f62eaa67ac83c1eb12bda1b7a08406dd286e252c11a66be27f81
home=$CACHE/python$VERSION-free-threaded
free=$home/bin/python3.14t

need build wheel curl libbz2-dev libffi-dev liblzma-dev libssl-dev xz-utils zlib1g-dev
if [[ ! -x $free ]]; then
    say "CPython $VERSION without the GIL"
    folder=$BUILD/python$VERSION
    rm -rf "$folder"
    mkdir -p "$folder"
    archive=python3.14_$VERSION.orig.tar.xz
    curl -fsSL -o "$folder/$archive" "$(mirror)/pool/main/p/python3.14/$archive" ||
        die "the mirror has no $archive; another VERSION may be there"
    echo "$HASH  $folder/$archive" | sha256sum --check --quiet
    tar -xJ -C "$folder" --strip-components=1 -f "$folder/$archive"
    (cd "$folder" && ./configure -q --disable-gil --prefix="$home" && make -s -j "$JOBS" && make -s install) \
        >"$folder.log" 2>&1 || die "see $folder.log"
fi

say "The wheel"
venv=$BUILD/venv/free-threaded wheels=$BUILD/wheels/free-threaded
rm -rf "$wheels"
PYTHON=$free environment "$venv" numpy pytest
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
