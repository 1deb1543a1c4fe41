# What the scripts share; sourced by them, from the repository's folder.
# shellcheck shell=bash

set -euo pipefail

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
BUILD=$ROOT/build
CACHE=$BUILD/cache  # what was fetched
JOBS=$(nproc)

# Debian's Python: another one on the PATH may lack numpy.
PYTHON=/usr/bin/python3

# Clones in other folders share what ccache holds.
export CCACHE_BASEDIR=$ROOT CCACHE_NOHASHDIR=1

say() { printf '\n=== %s\n' "$*"; }

die() {
    printf '%s: %s\n' "$(basename "$0")" "$*" >&2
    exit 1
}

as_root() {
    if ((EUID == 0)); then "$@"; else sudo "$@"; fi
}

# need PACKAGE...: installs the Debian packages that are missing.
need() {
    local package missing=()
    command -v apt-get >/dev/null || return 0  # not Debian: CMake says what is missing
    for package; do
        [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed ]] ||
            missing+=("$package")
    done
    ((${#missing[@]})) || return 0

    say "Installing ${missing[*]}"
    local install=(env DEBIAN_FRONTEND=noninteractive
        apt-get -o DPkg::Lock::Timeout=120 install -y -qq --no-install-recommends "${missing[@]}")
    # The package lists may be absent or older than the mirror.
    as_root "${install[@]}" >/dev/null 2>&1 ||
        { as_root apt-get update -qq && as_root "${install[@]}" >/dev/null; } ||
        die "could not install ${missing[*]}"
}

# configure FOLDER [OPTION...]: configures the standalone build.
configure() {
    local folder=$1 launcher=()
    shift
    if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
    cmake -S "$ROOT" -B "$folder" -DCMAKE_BUILD_TYPE=Release "${launcher[@]}" "$@"
}

build() { cmake --build "$1" --parallel "$JOBS" "${@:2}"; }

# run_tests FOLDER [ctest option...]: runs a build's tests, under the command TEST_WRAPPER if set. Ends with
# one line of counts: ctest's own summary does not say how many were skipped for want of data.
run_tests() {
    local folder=$1 status=0
    ${TEST_WRAPPER:-} ctest --test-dir "$folder" --parallel "$JOBS" --output-on-failure --no-tests=error \
        --output-junit "$folder/tests.xml" "${@:2}" || status=$?
    [[ $status == 0 || -e $folder/tests.xml ]] || return $status
    counts "$folder"
    return $status
}

# counts FOLDER: what run_tests found there, as "N passed, N failed, N skipped".
counts() {
    local total failures skipped
    total=$(junit tests "$1")
    failures=$(junit failures "$1")
    skipped=$(junit skipped "$1")
    echo "$((total - failures - skipped)) passed, $failures failed, $skipped skipped"
}

junit() { sed -n "s/^\t$1=\"\([0-9]*\)\"\$/\1/p" "$2/tests.xml"; }

# opencv_source: sets OPENCV_SOURCE to OpenCV's source as Debian packages it; fetched once. The system's apt
# configuration stays as it is: apt gets a source list and folders of our own.
opencv_source() {
    local folder=$CACHE/opencv-source
    if [[ ! -e $folder/complete ]]; then
        need dpkg-dev
        say "Fetching OpenCV's source package"
        rm -rf "$folder"
        mkdir -p "$folder"/{parts,lists/partial,apt/archives/partial}
        apt-get indextargets --format 'deb-src $(REPO_URI) $(RELEASE) $(COMPONENT)' \
            'Identifier: Packages' 'Origin: Debian' | sort -u >"$folder/parts/src.list"
        local apt=(apt-get -qq
            -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$folder/parts"
            -o Dir::State::Lists="$folder/lists" -o Dir::Cache="$folder/apt" -o APT::Sandbox::User="$(id -un)")
        "${apt[@]}" update
        (cd "$folder" && "${apt[@]}" source opencv >/dev/null)
        rm -rf "$folder"/{parts,lists,apt} "$folder"/*.tar.* "$folder"/*.dsc
        touch "$folder/complete"
    fi
    OPENCV_SOURCE=$(echo "$folder"/opencv-*/)
    OPENCV_SOURCE=${OPENCV_SOURCE%/}
}

# opencv_samples: sets OPENCV_SAMPLES to the sample images of Debian's opencv-doc; fetched once, not
# installed.
opencv_samples() {
    local folder=$CACHE/opencv-doc examples=usr/share/doc/opencv-doc/examples/data
    if [[ ! -e $folder/complete ]]; then
        say "Fetching OpenCV's sample images (the package opencv-doc)"
        rm -rf "$folder"
        mkdir -p "$folder"
        (
            cd "$folder"
            apt-get download -qq opencv-doc 2>/dev/null ||
                { as_root apt-get update -qq && apt-get download -qq opencv-doc; }
            dpkg-deb --fsys-tarfile opencv-doc_*.deb | tar -x "./$examples"
            rm opencv-doc_*.deb
            find . -name '*.gz' -exec gunzip {} +
            touch complete
        )
    fi
    OPENCV_SAMPLES=$folder/$examples
}
