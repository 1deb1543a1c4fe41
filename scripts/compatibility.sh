#!/usr/bin/env bash
# Builds and runs all tests on other CPUs, with other versions of OpenCV and with other compilers, and compares the
# bytes of keypoints and descriptors with those of the ordinary build.
#
#   scripts/compatibility.sh [--bytes] [ROW ...]
#
# Ends with one line for each row of the table in doc/reliability.md; all rows by default. With --bytes the tests
# are left out. The rows are presets of CMakePresets.json, except debian12, debian13 and plain, which use the preset
# release. The builds are in build, the logs in build/compatibility.
#
#   debian12    the ordinary build
#   debian13    the same on a Debian 13 in a folder of its own; needs root
#   opencv4     the newest OpenCV 4, built from source with scripts/opencv.sh --release 4, which runs all tests inside it
#   opencv5     the same of OpenCV 5
#   avx2, sse4, sse2
#               the same build with the features of newer x86-64 CPUs disabled
#   plain       the same build with cv::setUseOptimized(false); bytes only
#   aarch64, armhf, riscv64, s390x
#               cross-built, on an emulated CPU; armhf with NEON, s390x big-endian
#   i386        cross-built for SSE2, on this CPU
#   windows     cross-built with MinGW-w64 against OpenCV 4, which it builds first, under wine
#   clang       clang++
#
# Installs the Debian packages it needs. Tests that need images of opencv_extra are skipped unless
# OPENCV_TEST_DATA_PATH names its testdata folder.
source "$(dirname "$0")/common.sh"

FOLDER=$BUILD/compatibility
images=()
if [[ -n ${OPENCV_TEST_DATA_PATH:-} ]]; then
    OPENCV_TEST_DATA_PATH=$(cd "$OPENCV_TEST_DATA_PATH" && pwd)
    images=({bark,bikes,graf,leuven,trees,ubc}/img1.png)
fi
photographs=cv/detectors_descriptors_evaluation/images_datasets

# built PRESET [TEST-PRESET]: builds, and runs the tests unless they are left out.
built() {
    configure "$1" -DAQORB_BUILD_FINGERPRINT=ON -DAQORB_WERROR=ON
    if [[ $bytes_only ]]; then
        build "$BUILD/$1" --target aqorb_fingerprint
    else
        build "$BUILD/$1"
        run_tests "${2:-$1}"
    fi
}

# fingerprint ROW COMMAND...: the hashes of what the program COMMAND computes.
fingerprint() {
    local row=$1
    shift
    mkdir -p "$FOLDER/bytes"
    (
        if ((${#images[@]})); then cd "$OPENCV_TEST_DATA_PATH/$photographs"; fi
        "$@" "${images[@]}" | tr -d '\r' >"$FOLDER/bytes/$row.new"
    ) 2> >(tee "$FOLDER/bytes/$row.features" >&2)
    if grep 'unknown CPU feature' "$FOLDER/bytes/$row.features"; then return 1; fi
    mv "$FOLDER/bytes/$row.new" "$FOLDER/bytes/$row"
}

# compiled ROW [COMMAND...]: the build of a preset, whose programs run by a command.
compiled() {
    local row=$1
    shift
    built "$row"
    fingerprint "$row" "$@" "$BUILD/$row/tools/fingerprint/aqorb_fingerprint"
}

# disabled ROW FEATURES: the ordinary build without some features of the CPU, as the test preset ROW has it.
disabled() {
    built release "$1"
    OPENCV_CPU_DISABLE=$2 fingerprint "$1" "$BUILD/release/tools/fingerprint/aqorb_fingerprint"
}

row_debian12() {
    built release
    fingerprint debian12 "$BUILD/release/tools/fingerprint/aqorb_fingerprint"
}

# inside COMMAND...: runs a command on a Debian 13 in a folder of its own, in a mount namespace that ends with it. The
# repository is /aqorb, with a build folder of its own, and the test data is /data.
inside() {
    # shellcheck disable=SC2016
    as_root unshare --mount sh -ec '
        system=$1 root=$2 build=$3 data=$4
        shift 4
        mount -t proc proc "$system/proc"
        mount --bind "$root" "$system/aqorb"
        mount --bind "$build" "$system/aqorb/build"
        unset OPENCV_TEST_DATA_PATH AQORB_TEST_SEQUENCE
        if [ -n "$data" ]; then
            mount --bind "$data" "$system/data"
            export OPENCV_TEST_DATA_PATH=/data
        fi
        export CCACHE_DIR=/aqorb/build/ccache
        exec chroot "$system" "$@"' sh "$CACHE/debian13" "$ROOT" "$FOLDER/debian13" "${OPENCV_TEST_DATA_PATH:-}" "$@"
}

row_debian13() {
    local system=$CACHE/debian13
    need system
    if [[ ! -e $system.complete ]]; then
        as_root rm -rf "$system"
        mkdir -p "$CACHE"
        as_root debootstrap --variant=minbase --include="$(tr ' ' , <<<"${PACKAGES[build]} ${PACKAGES[test]}")" \
            trixie "$system" "$(mirror)"
        as_root mkdir "$system/aqorb" "$system/data"
        touch "$system.complete"
    fi
    mkdir -p "$FOLDER/debian13"
    inside bash -ec 'source /aqorb/scripts/common.sh
        configure release -DAQORB_BUILD_FINGERPRINT=ON -DAQORB_WERROR=ON
        if [[ $1 ]]; then
            build /aqorb/build/release --target aqorb_fingerprint
        else
            build /aqorb/build/release
            run_tests release
        fi' bash "$bytes_only"
    # shellcheck disable=SC2016
    fingerprint debian13 inside sh -ec \
        'if [ "$OPENCV_TEST_DATA_PATH" ]; then cd "/data/$0"; fi
        exec /aqorb/build/release/tools/fingerprint/aqorb_fingerprint "$@"' "$photographs"
}

# released 4|5
released() {
    [[ $bytes_only && -e $BUILD/opencv-$1/OpenCVConfig.cmake ]] || "$ROOT/scripts/opencv.sh" --release "$1"
    compiled "opencv$1"
}

row_opencv4() { released 4; }
row_opencv5() { released 5; }

row_avx2() { disabled avx2 AVX512-SKX; }

row_sse4() { disabled sse4 FMA3,AVX,AVX2,AVX512-SKX; }

row_sse2() { disabled sse2 SSE3,SSSE3,SSE4.1,SSE4.2,POPCNT,FP16,FMA3,AVX,AVX2,AVX512-SKX; }

row_plain() {
    bytes_only=1 built release
    fingerprint plain "$BUILD/release/tools/fingerprint/aqorb_fingerprint" --plain
}

# cross ROW ARCHITECTURE [EMULATOR]: cross-built with the compiler and the packages of Debian for an architecture, by
# Debian's name of it. Its programs run under qemu-user with the name of the emulated CPU, or by a given command.
cross() {
    need emulation "$2"
    sysroot "$2"
    if [[ $2 == i386 ]]; then
        compiled "$1" "$SYSROOT/lib/i386-linux-gnu/ld-linux.so.2" --library-path "$SYSROOT/lib/i386-linux-gnu:$SYSROOT/lib"
    else
        compiled "$1" "qemu-$3-static" -L "$SYSROOT"
    fi
}

row_aarch64() { cross aarch64 arm64 aarch64; }
row_armhf() { cross armhf armhf arm; }
row_i386() { cross i386 i386; }
row_riscv64() {
    # The linker of Debian 12 crashes on the GoogleTest of Debian 13.
    need emulation riscv64
    sysroot riscv64
    googletest "$SYSROOT/usr" debian-cross -DAQORB_ARCHITECTURE=riscv64 -DAQORB_SYSROOT="$SYSROOT" \
        -DCMAKE_INSTALL_LIBDIR=lib/riscv64-linux-gnu
    cross riscv64 riscv64 riscv64
}
row_s390x() { cross s390x s390x s390x; }

# googletest PREFIX TOOLCHAIN [OPTION ...]: builds GoogleTest for another machine, and installs it in PREFIX.
googletest() {
    local folder=$1/src/build-googletest
    [[ ! -e $folder/install_manifest.txt ]] || return 0
    cmake -S /usr/src/googletest -B "$folder" -DCMAKE_TOOLCHAIN_FILE="$ROOT/cmake/$2.cmake" \
        -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$1" -DBUILD_GMOCK=OFF "${@:3}"
    cmake --build "$folder" --parallel "$JOBS" --target install
}

# windows_opencv: builds OpenCV and GoogleTest for Windows in build/opencv-windows, and puts the compiler's own DLLs
# beside them.
windows_opencv() {
    local prefix=$BUILD/opencv-windows dll feature options=() triplet=x86_64-w64-mingw32
    [[ ! -e $prefix/complete ]] || return 0
    opencv_release 4
    for feature in 1394 ADE DSHOW EIGEN FFMPEG FLATBUFFERS GSTREAMER IPP ITT JASPER LAPACK MSMF OBSENSOR OPENCL OPENEXR \
        OPENJPEG PROTOBUF QUIRC TIFF WEBP; do
        options+=("-DWITH_$feature=OFF")
    done
    cmake -S "$OPENCV_SOURCE" -B "$prefix/build" -G Ninja \
        -DCMAKE_TOOLCHAIN_FILE="$ROOT/cmake/mingw-w64.cmake" -DAQORB_WINDOWS="$prefix" \
        -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" -DENABLE_CCACHE=OFF \
        -DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache \
        -DBUILD_LIST=core,imgproc,features2d,flann,calib3d,imgcodecs,stitching,highgui,videoio \
        -DCPU_BASELINE=SSE2 -DCPU_DISPATCH=SSE4_1,AVX2 -DBUILD_ZLIB=ON -DBUILD_PNG=ON -DBUILD_JPEG=ON \
        -DBUILD_TESTS=OFF -DBUILD_PERF_TESTS=OFF -DBUILD_EXAMPLES=OFF -DBUILD_opencv_apps=OFF -DBUILD_JAVA=OFF \
        -DBUILD_opencv_python3=OFF -DOPENCV_DOWNLOAD_TRIES_LIST= -DOPENCV_GENERATE_PKGCONFIG=OFF "${options[@]}"
    cmake --build "$prefix/build" --parallel "$JOBS" --target install
    googletest "$prefix" mingw-w64 -DAQORB_WINDOWS="$prefix"
    mkdir -p "$prefix/bin"
    for dll in libstdc++-6.dll libgcc_s_seh-1.dll libwinpthread-1.dll; do
        cp "$("$triplet-g++-posix" -print-file-name="$dll")" "$prefix/bin"
    done
    rm -r "$prefix/build"
    touch "$prefix/complete"
}

row_windows() {
    local prefix=$BUILD/opencv-windows
    need windows
    windows_opencv
    built windows
    fingerprint windows env WINEDEBUG=-all WINEPREFIX="$prefix/wine" WINEPATH="Z:$prefix/bin" /usr/lib/wine/wine64 \
        "$BUILD/windows/bin/aqorb_fingerprint.exe"
}

row_clang() { need clang; compiled clang; }

bytes_only=
if [[ ${1:-} == --bytes ]]; then
    bytes_only=1
    shift
fi
rows=("$@")
((${#rows[@]})) || rows=(debian12 debian13 opencv4 opencv5 avx2 sse4 sse2 plain
    aarch64 armhf i386 riscv64 s390x windows clang)
for row in "${rows[@]}"; do
    declare -F "row_$row" >/dev/null || die "no such row: $row"
done

need build test
rm -rf "$FOLDER/bytes"
mkdir -p "$FOLDER/bytes"

# start ROW: in a process of its own, as what a row exports ends with it. Not within a condition, where bash would
# ignore errors.
start() {
    say "$1"
    SECONDS=0
    "row_$1" >"$FOLDER/$1.log" 2>&1 &
}

# equal_lines ROW [SED-COMMAND]: how many of its lines of hashes are those of the ordinary build.
equal_lines() {
    comm -12 <(sed "${2:-}" "$FOLDER/bytes/debian12" | sort) <(sed "${2:-}" "$FOLDER/bytes/$1" | sort) | wc -l
}

# verdict ROW: the counts of its tests, and how many of its lines of hashes are those of the ordinary build. On i386 and
# Windows distributionUniformity may have another last bit, as the C library's logarithm has.
verdict() {
    local counts total equal
    counts=$(grep '^[0-9]* passed, ' "$FOLDER/$1.log" | tail -n 1)
    total=$(wc -l <"$FOLDER/bytes/debian12")
    equal=$(equal_lines "$1")
    printf '%s; bytes: %s of %s equal' "${counts:-no tests}" "$equal" "$total"
    if ((equal < total)) && [[ $1 == i386 || $1 == windows ]]; then
        equal=$(equal_lines "$1" 's/ measures [0-9a-f]*//')
        printf ', %s without the measures' "$equal"
    fi
    echo "; $SECONDS s"
    ((equal == total && total > 0))
}

# The bytes to compare with come first.
if [[ ${rows[0]} != debian12 ]]; then
    wanted=$bytes_only bytes_only=1
    start debian12
    wait $! || die "see $FOLDER/debian12.log"
    bytes_only=$wanted
fi

status=0
summary=()
for row in "${rows[@]}"; do
    start "$row"
    result=
    if wait $! && result=$(verdict "$row"); then
        echo "$result"
    else
        status=1
        tail -n 40 "$FOLDER/$row.log"
        result="FAILED: ${result:-see $FOLDER/$row.log}"
    fi
    summary+=("$(printf '%-10s %s' "$row" "$result")")
done

say "Summary"
printf '%s\n' "${summary[@]}"
exit $status
