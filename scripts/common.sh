# shellcheck shell=bash disable=SC2034
# What the scripts share: the packages that each kind of work needs, what is fetched, configuring, building and testing,
# and --help, which prints the comment at the head of a script. The scripts source it; it does nothing by itself.

set -euo pipefail

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
BUILD=$ROOT/build
CACHE=$BUILD/cache  # what was fetched
JOBS=$(nproc)

# What the Python package index has of OpenCV: the newest release of version 4, and version 5.
OPENCV_4=4.14.0.94
OPENCV_5=5.0.0.93

# What the command aqorb needs. This pyarrow is for the NumPy 1 of Debian 12.
COMMAND=(pillow-heif==0.13.1 pyarrow==21.0.0 pycolmap==4.2.1 scipy==1.13.1 tqdm==4.70.1)

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
    [emulation]='dpkg-dev qemu-user-static'
    [wheel]='ca-certificates ninja-build python3-dev python3-venv'
    [workflows]='ca-certificates python3-venv shellcheck'
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

# forget_moved FOLDER SOURCE: CMake refuses to configure a folder again that was configured under another name, for
# example before the clone was moved. This function removes what CMake remembers of it.
forget_moved() {
    local cache=$1/CMakeCache.txt was
    [[ -e $cache ]] || return 0
    was=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$cache")
    if [[ $was != "$2" || $(sed -n 's/^CMAKE_CACHEFILE_DIR:INTERNAL=//p' "$cache") != "$1" ]]; then
        echo "$1 was configured for $was: configuring it anew"
        rm -rf "$cache" "$1/CMakeFiles"
    fi
}

# own_apt FOLDER ARCHITECTURE LINE...: sets OWN_APT to options of apt-get. With them it has folders of its own, in FOLDER,
# and these lines as its sources: the system's configuration and its architectures stay as they are.
own_apt() {
    mkdir -p "$1"/{parts,lists/partial,apt/archives/partial}
    printf '%s\n' "${@:3}" >"$1/parts/own.list"
    touch "$1/status"
    OWN_APT=(-o APT::Architecture="$2" -o APT::Architectures="$2" -o APT::Sandbox::User="$(id -un)"
        -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$1/parts"
        -o Dir::State::Status="$1/status" -o Dir::State::Lists="$1/lists" -o Dir::Cache="$1/apt")
}

# sysroot ARCHITECTURE: installs the cross compiler and the emulator for an architecture, by Debian's name of it, and
# sets SYSROOT to a folder with the packages of OpenCV and GoogleTest for it, unpacked; fetched once. They are those of
# this Debian, or of Debian 13, the first that has riscv64.
sysroot() {
    local folder=$CACHE/$1 release triplet directory package
    need emulation
    triplet=$(dpkg-architecture -f -a "$1" -q DEB_HOST_MULTIARCH)
    need "g++-$triplet"
    SYSROOT=$folder/root
    [[ ! -e $folder/complete ]] || return 0
    rm -rf "$folder"
    mkdir -p "$folder"/root/usr/{bin,lib,sbin}
    release=$(codename)
    [[ $1 != riscv64 || $release != bookworm ]] || release=trixie
    own_apt "$folder" "$1" "deb [arch=$1] $(mirror) $release main"
    apt-get -qq "${OWN_APT[@]}" update
    apt-get -qq "${OWN_APT[@]}" install -y --no-install-recommends --download-only \
        libgtest-dev libopencv-dev libstdc++-12-dev

    for directory in bin lib sbin; do ln -s "usr/$directory" "$SYSROOT/$directory"; done
    for package in "$folder"/apt/archives/*.deb; do
        dpkg-deb --fsys-tarfile "$package" | tar -x -C "$SYSROOT" --keep-directory-symlink --no-same-owner
    done
    # What update-alternatives would choose.
    ln -s blas/libblas.so.3 lapack/liblapack.so.3 "$SYSROOT/usr/lib/$triplet/"
    rm -r "$folder"/{apt,lists,parts,status}
    touch "$folder/complete"
}

# configure PRESET [OPTION...]: by CMakePresets.json. What CMake prints is shown if it fails.
configure() {
    local preset=$1 log=$BUILD/$1.configure.log
    forget_moved "$BUILD/$preset" "$ROOT"
    mkdir -p "$BUILD"
    (cd "$ROOT" && cmake --preset "$preset" "${@:2}") >"$log" 2>&1 || { cat "$log" && die "CMake failed, see $log"; }
    grep -A 4 'CMake Warning\|left out' "$log" || true
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

# environment FOLDER PACKAGE...: a clean virtual environment of Debian's Python with these packages. Tools have the
# versions of scripts/tools.txt.
environment() {
    "$PYTHON" -m venv --clear "$1"
    "$1/bin/pip" install -q --upgrade pip
    (($# == 1)) || "$1/bin/pip" install -q --constraint "$ROOT/scripts/tools.txt" "${@:2}"
}

# command_environment NAME [PACKAGE...]: sets PYTHON to one that sees Debian's packages and has besides what the command
# aqorb needs, and these; made once.
command_environment() {
    local folder=$BUILD/venv/$1 requirements=("${COMMAND[@]}" "${@:2}")
    if [[ $(cat "$folder/requirements" 2>/dev/null) != "${requirements[*]}" ]]; then
        "$PYTHON" -m venv --clear --system-site-packages "$folder"
        "$folder/bin/pip" install -q --disable-pip-version-check --only-binary :all: "${requirements[@]}" ||
            die "could not fetch from the Python package index; is there a network?"
        echo "${requirements[*]}" >"$folder/requirements"
    fi
    PYTHON=$folder/bin/python
}

# opencv_source: sets OPENCV_SOURCE to OpenCV's source as Debian packages it; fetched once.
opencv_source() {
    local folder=$CACHE/opencv-source sources
    if [[ ! -e $folder/complete ]]; then
        need dpkg-dev
        say "Fetching OpenCV's source package"
        rm -rf "$folder"
        sources=$(apt-get indextargets --format 'deb-src $(REPO_URI) $(RELEASE) $(COMPONENT)' \
            'Identifier: Packages' 'Origin: Debian' | sort -u)
        own_apt "$folder" "$(dpkg --print-architecture)" "$sources"
        (cd "$folder" && "${APT[@]}" "${OWN_APT[@]}" update && "${APT[@]}" "${OWN_APT[@]}" source opencv) ||
            die "could not fetch OpenCV's source package; is there a network?"
        rm -rf "$folder"/{parts,lists,apt,status} "$folder"/*.tar.* "$folder"/*.dsc
        touch "$folder/complete"
    fi
    OPENCV_SOURCE=$(echo "$folder"/opencv-*/)
    OPENCV_SOURCE=${OPENCV_SOURCE%/}
}

# opencv_release 4|5: sets OPENCV_SOURCE to the source of OPENCV_4 or OPENCV_5, which is in the source distribution of
# opencv-python-headless; fetched once.
opencv_release() {
    local release=$OPENCV_4 hash=4afa2ea1214453648be88259f035712454faa9039b686de7753569ba8eec1577
    if [[ $1 == 5 ]]; then
        release=$OPENCV_5 hash=b82f9831daab90b725c7c1ee1b36cb5732c367096ac76d119e64e14eb70d5f3c
    fi
    OPENCV_SOURCE=$CACHE/opencv-$release/opencv
    source_distribution opencv-python-headless "$release" "$hash" "$OPENCV_SOURCE"
}

# contrib_release: sets CONTRIB_SOURCE to the opencv_contrib of OPENCV_4, which is in the source distribution of
# opencv-contrib-python-headless; fetched once.
contrib_release() {
    CONTRIB_SOURCE=$CACHE/opencv_contrib-$OPENCV_4/opencv_contrib
    source_distribution opencv-contrib-python-headless "$OPENCV_4" \
        6cd98a20010c80bf9e6a9cff6189dd2c10bd111fb0aa4d5c6361389514a0ff6c "$CONTRIB_SOURCE"
}

# source_distribution PACKAGE VERSION SHA256 FOLDER/NAME: puts what the Python package index has of a package's source in
# its folder NAME there; fetched once.
source_distribution() {
    local folder=${4%/*}
    if [[ ! -e $folder/complete ]]; then
        need wheel
        say "Fetching the source of $1 $2 from the Python package index"
        rm -rf "$folder"
        mkdir -p "$folder"
        "$PYTHON" -m venv "$folder/venv"
        echo "$1==$2 --hash=sha256:$3" >"$folder/requirements"
        # pip says how much it fetches.
        "$folder/venv/bin/pip" download --disable-pip-version-check --no-deps \
            --no-binary "$1" --require-hashes --requirement "$folder/requirements" \
            --dest "$folder" || die "could not fetch from the Python package index; is there a network?"
        tar -xz -C "$folder" -f "$folder"/*.tar.gz --strip-components=1 --wildcards "*/${4##*/}"
        rm -r "$folder"/*.tar.gz "$folder/venv"
        touch "$folder/complete"
    fi
}

# debian_file PACKAGE FOLDER: puts a Debian package's file into a folder without installing it.
debian_file() {
    # Without a sandbox, for whose user root's folders are closed.
    local download=("${APT[@]}" -o APT::Sandbox::User="$(id -un)" download "$1")
    (cd "$2" && { "${download[@]}" || { as_root "${APT[@]}" update && "${download[@]}"; }; }) ||
        die "could not fetch the package $1; is there a network?"
}

# held_out_packages: sets HELD_OUT_SOURCES to a folder with the packages of tools/evaluate/held_out.csv, unpacked and
# not installed; fetched once. Call opencv_source first.
held_out_packages() {
    local folder=$CACHE/held_out package wheel
    if [[ ! -e $folder/complete ]]; then
        say "Fetching the packages of the held-out images"
        rm -rf "$folder"
        mkdir -p "$folder"
        for package in visp-images-data octave-vlfeat; do
            mkdir "$folder/$package"
            debian_file "$package" "$folder"
            dpkg-deb -x "$folder/$package"_*.deb "$folder/$package"
        done
        cat >"$folder/requirements" <<-'END'
			image-matching-models==1.1.0 --hash=sha256:48503a972801714afc9b477e6819b06e40ec62e09afc74b34916d0335e1d2bd4
			stereodemo==0.7 --hash=sha256:effd07da657295e834aa1b0c89cc962e953d66b506a75365ad32a1114f2389ec
		END
        "$PYTHON" -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: \
            --require-hashes --requirement "$folder/requirements" --dest "$folder" ||
            die "could not fetch from the Python package index; is there a network?"
        for wheel in "$folder"/*.whl; do
            package=$(basename "${wheel%%-[0-9]*}")
            "$PYTHON" -m zipfile -e "$wheel" "$folder/${package//_/-}"
        done
        rm "$folder"/*.deb "$folder"/*.whl
        touch "$folder/complete"
    fi
    ln -sfn "$OPENCV_SOURCE" "$folder/opencv"
    HELD_OUT_SOURCES=$folder
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
