# shellcheck shell=bash disable=SC2034
# What the scripts share: the packages that each kind of work needs, what is fetched, configuring, building and testing,
# and --help, which prints the comment at the head of a script. The scripts source it; it does nothing by itself.

set -euo pipefail

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
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

if [[ ${1:-} == --help || ${1:-} == -h ]]; then
    sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"
    exit
fi

as_root() {
    if ((EUID == 0)); then "$@"; else sudo "$@"; fi
}

# The Debian packages that each kind of work needs; this is the only list of them.
declare -A PACKAGES=(
    [build]='build-essential cmake ccache libopencv-dev'
    [test]='libgtest-dev pkg-config'
    [python]='locales mypy pybind11-dev python3-dev python3-numpy python3-opencv python3-pil python3-pytest python3-venv'
    [doc]='cmark-gfm doxygen doxygen-awesome-css graphviz python3 texlive-binaries'
    [soak]='libgtest-dev valgrind'
    [fuzz]='clang libclang-rt-dev llvm libgtest-dev'
    [format]='clang-format clang-tidy shellcheck'
    [opencv]='dpkg-dev ninja-build zlib1g-dev libpng-dev libjpeg-dev python3-dev python3-numpy'
    [java]='ant default-jdk-headless'
    [emulation]='g++-aarch64-linux-gnu qemu-user-static'
    [wheel]='ca-certificates ninja-build python3-dev python3-venv'
)

# need NAME...: installs what is missing of the groups above, and of other Debian packages.
need() {
    local name package absent=()
    command -v apt-get >/dev/null || return 0  # not Debian: CMake says what is absent
    # shellcheck disable=SC2013,SC2086 # a list of names
    for package in $(for name; do printf '%s\n' ${PACKAGES[$name]:-$name}; done | sort -u); do
        [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed ]] ||
            absent+=("$package")
    done
    ((!${#absent[@]})) || install_packages "${absent[@]}"
}

# apt-get, which gives up soon if the network does not answer.
APT=(env DEBIAN_FRONTEND=noninteractive apt-get -o APT::Update::Error-Mode=any -o Acquire::Retries=1
    -o Acquire::http::Timeout=30 -o DPkg::Lock::Timeout=120)

# install_packages PACKAGE...: apt-get says how much that is, and shows its progress.
install_packages() {
    local install=(install -y --no-install-recommends "$@")
    local by_hand="apt-get update && apt-get install --no-install-recommends $*"
    if ((EUID != 0)) && { ! command -v sudo >/dev/null || { ! sudo -n true 2>/dev/null && [[ ! -t 0 ]]; }; }; then
        die "only root can install the missing packages. As root, run
  $by_hand"
    fi
    say "Installing $*"
    # The lists of packages may be absent or older than the mirror.
    as_root "${APT[@]}" "${install[@]}" ||
        { as_root "${APT[@]}" update && as_root "${APT[@]}" "${install[@]}"; } ||
        die "could not install the packages. Without a network, do later, as root:
  $by_hand"
}

# run_cmake NAME SOURCE [OPTION...]: configures build/NAME. The output of CMake is shown if it fails. CMake refuses a
# folder that was configured under another name, for example before the clone was moved. It is then configured anew.
run_cmake() {
    local folder=$BUILD/$1 source=$2 log=$BUILD/$1.configure.log fresh=() same
    same=$(grep -cxF "CMAKE_HOME_DIRECTORY:INTERNAL=$source
CMAKE_CACHEFILE_DIR:INTERNAL=$folder" "$folder/CMakeCache.txt" 2>/dev/null) || true
    [[ ! -e $folder/CMakeCache.txt || $same == 2 ]] || fresh=(--fresh)
    mkdir -p "$BUILD"
    # OpenCV's configuration takes minutes, so it is shown.
    (cd "$ROOT" && cmake "${fresh[@]}" -S "$source" -B "$folder" "${@:3}") 2>&1 |
        if [[ $source == "$ROOT" ]]; then cat >"$log"; else tee "$log"; fi ||
        { tail -n 50 "$log" && die "CMake failed, see $log"; }
    grep -A 4 'CMake Warning\|left out' "$log" || true
}

# configure PRESET [OPTION...]: by CMakePresets.json.
configure() { run_cmake "$1" "$ROOT" --preset "$1" "${@:2}"; }

# configure_beside NAME SOURCE: a project that compiles a part of OpenCV's source.
configure_beside() {
    run_cmake "$1" "$2" -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER_LAUNCHER=ccache \
        -DOPENCV_SOURCE_DIR="$OPENCV_SOURCE"
}

# configure_opencv NAME MODULES-PATH [OPTION...]: OpenCV itself, with the modules of another folder.
configure_opencv() {
    mkdir -p "$BUILD"
    cmake -S "$OPENCV_SOURCE" -B "$BUILD/$1" -C "$ROOT/cmake/opencv_options.cmake" -DCMAKE_C_COMPILER_LAUNCHER=ccache \
        -DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DOPENCV_EXTRA_MODULES_PATH="$2" "${@:3}" 2>&1 |
        tee "$BUILD/$1.configure.log"
}

# build FOLDER [OPTION...]: says what is compiled, and not what is there.
build() {
    [[ -n $(find "$1" -name '*.o' -print -quit) ]] || echo "Compiling for the first time, which takes some minutes"
    cmake --build "$1" --parallel "$JOBS" "${@:2}" | sed -u '/Built target\|Consolidate compiler\|no work to do/d'
}

# run_tests PRESET [ctest option...]: runs the tests of a preset. Ends with one line of counts: ctest's own summary
# does not say how many were skipped for want of data.
run_tests() {
    local preset=$1 results=$BUILD/tests/$1.xml status=0
    mkdir -p "$BUILD/tests"
    rm -f "$results"
    (cd "$ROOT" && ctest --preset "$preset" --parallel "$JOBS" --output-junit "$results" "${@:2}") || status=$?
    [[ $status == 0 || -e $results ]] || return $status
    [[ ${OPENCV_TEST_DATA_PATH:-} ]] || echo "OPENCV_TEST_DATA_PATH is not set, so tests on photographs are skipped"
    counts "$preset"
    return $status
}

# counts PRESET: what run_tests found, as "N passed, N failed, N skipped".
counts() {
    local total failures skipped results=$BUILD/tests/$1.xml
    total=$(junit tests "$results")
    failures=$(junit failures "$results")
    skipped=$(junit skipped "$results")
    echo "$((total - failures - skipped)) passed, $failures failed, $skipped skipped"
}

junit() { sed -n "s/^\t$1=\"\([0-9]*\)\"\$/\1/p" "$2"; }

# The name of this Debian's release.
codename() { sed -n 's/^VERSION_CODENAME=//p' /etc/os-release; }

# The mirror that this system has its packages from.
mirror() {
    apt-get indextargets --format '$(REPO_URI)' 'Identifier: Packages' 'Origin: Debian' "Codename: $(codename)" |
        sed 's#/*$##; q'
}

# tools PACKAGE...: sets TOOLS to the programs of a virtual environment of Debian's Python with these packages of
# scripts/tools.txt.
tools() {
    TOOLS=$BUILD/venv/tools/bin
    need wheel
    [[ -e $TOOLS/pip ]] || "$PYTHON" -m venv "$BUILD/venv/tools"
    "$TOOLS/python" -m pip install -q --disable-pip-version-check --constraint "$ROOT/scripts/tools.txt" "$@" ||
        die "could not fetch from the Python package index; is there a network?"
}

# opencv_source: sets OPENCV_SOURCE to OpenCV's source as Debian packages it; fetched once.
opencv_source() {
    local folder=$CACHE/opencv-source apt
    if [[ ! -e $folder/complete ]]; then
        need dpkg-dev
        say "Fetching OpenCV's source package"
        rm -rf "$folder"
        mkdir -p "$folder"/{lists/partial,apt/archives/partial}
        apt-get indextargets --format 'deb-src $(REPO_URI) $(RELEASE) $(COMPONENT)' \
            'Identifier: Packages' 'Origin: Debian' | sort -u >"$folder/sources.list"
        # With lists of its own, so that the system's configuration stays as it is.
        apt=("${APT[@]}" -o APT::Sandbox::User="$(id -un)" -o Dir::Etc::SourceList="$folder/sources.list"
            -o Dir::Etc::SourceParts=/dev/null -o Dir::State::Lists="$folder/lists" -o Dir::Cache="$folder/apt")
        (cd "$folder" && "${apt[@]}" update && "${apt[@]}" source opencv) ||
            die "could not fetch OpenCV's source package; is there a network?"
        rm -rf "$folder"/{lists,apt} "$folder"/*.tar.* "$folder"/*.dsc
        touch "$folder/complete"
    fi
    OPENCV_SOURCE=$(echo "$folder"/opencv-*/)
    OPENCV_SOURCE=${OPENCV_SOURCE%/}
}

# opencv_release PACKAGE MAJOR: sets OPENCV_SOURCE to the source of a release that the Python package index has. That of
# opencv_contrib lies beside it.
opencv_release() {
    tools pip
    cmake -DPACKAGE="$1" -DMAJOR="$2" -DFOLDER="$CACHE/$1-$2" -DPYTHON="$TOOLS/python" \
        -P "$ROOT/cmake/fetch_opencv.cmake"
    OPENCV_SOURCE=$CACHE/$1-$2/source/opencv
}

# debian_file PACKAGE FOLDER: puts a Debian package's file into a folder without installing it.
debian_file() {
    # Without a sandbox, for whose user root's folders are closed.
    local download=("${APT[@]}" -o APT::Sandbox::User="$(id -un)" download "$1")
    (cd "$2" && { "${download[@]}" || { as_root "${APT[@]}" update && "${download[@]}"; }; }) ||
        die "could not fetch the package $1; is there a network?"
}

# opencv_samples: sets OPENCV_SAMPLES to the sample images of Debian's opencv-doc; fetched once, not
# installed.
opencv_samples() {
    local folder=$CACHE/opencv-doc examples=usr/share/doc/opencv-doc/examples/data
    if [[ ! -e $folder/complete ]]; then
        say "Fetching OpenCV's sample images: the package opencv-doc, 100 MB, which is not installed"
        rm -rf "$folder"
        mkdir -p "$folder"
        (
            cd "$folder"
            debian_file opencv-doc "$folder"
            dpkg-deb --fsys-tarfile opencv-doc_*.deb | tar -x "./$examples"
            rm opencv-doc_*.deb
            find . -name '*.gz' -exec gunzip {} +
            touch complete
        )
    fi
    OPENCV_SAMPLES=$folder/$examples
}

# strecha SCENE...: sets AQORB_STRECHA, unless it is set, to a clone with these scenes of Strecha's calibrated
# photographs; fetched once. Fails where there is no network.
strecha() {
    local clone=$CACHE/strecha git=(git -c http.lowSpeedLimit=1000 -c http.lowSpeedTime=30)
    [[ ! ${AQORB_STRECHA:-} ]] || return 0
    need git ca-certificates
    if [[ ! -d $clone ]]; then
        say "Fetching Strecha's photographs, some 30 MB a scene: $*"
        "${git[@]}" clone --depth 1 --filter=blob:none --sparse \
            https://github.com/openMVG/SfM_quality_evaluation "$clone" || return 1
    fi
    "${git[@]}" -C "$clone" sparse-checkout add "${@/#/Benchmarking_Camera_Calibration_2008/}" || return 1
    AQORB_STRECHA=$clone
}
