#!/usr/bin/env bash
# Builds and runs all tests on other CPUs, with other versions of OpenCV and with other compilers, and compares the
# bytes of keypoints and descriptors with those of the ordinary build.
#
#   scripts/compatibility.sh [--bytes] [ROW ...]
#
# Ends with one line for each row of the table in doc/reliability.md; all rows by default. With --bytes the tests
# are left out. opencv4, opencv5, aarch64 and clang are presets of CMakePresets.json. The other rows use the preset
# release. The builds are in build, the logs in build/compatibility.
#
#   debian12    the ordinary build
#   debian13    the same on a Debian 13 in a folder of its own
#   opencv4     the newest OpenCV 4, built from source with scripts/opencv.sh --release 4, which runs all tests inside it
#   opencv5     the same of OpenCV 5
#   avx2, sse4, sse2
#               the same build with the features of newer x86-64 CPUs disabled
#   plain       the same build with cv::setUseOptimized(false); bytes only
#   aarch64     cross-built, on an emulated CPU
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

# built PRESET: builds, and runs the tests unless they are left out.
built() {
    configure "$1" -DAQORB_BUILD_FINGERPRINT=ON -DAQORB_WERROR=ON
    if [[ $bytes_only ]]; then
        build "$BUILD/$1" --target aqorb_fingerprint
    else
        build "$BUILD/$1"
        run_tests "$1"
    fi
}

# fingerprint ROW COMMAND...: the hashes of what the program COMMAND computes.
fingerprint() {
    local row=$1
    shift
    mkdir -p "$FOLDER/bytes"
    (
        if ((${#images[@]})); then cd "$OPENCV_TEST_DATA_PATH/$photographs"; fi
        "$@" "${images[@]}" >"$FOLDER/bytes/$row.new"
    ) 2> >(tee "$FOLDER/bytes/$row.features" >&2)
    if grep 'unknown CPU feature' "$FOLDER/bytes/$row.features"; then return 1; fi
    mv "$FOLDER/bytes/$row.new" "$FOLDER/bytes/$row"
}

# compiled ROW [COMMAND...]: the build of a preset, whose programs run by a command.
compiled() {
    local row=$1
    shift
    built "$row"
    fingerprint "$row" "$@" "$BUILD/$row/tools/aqorb_fingerprint"
}

# disabled ROW FEATURES: the ordinary build without some features of the CPU.
disabled() {
    export OPENCV_CPU_DISABLE=$2
    built release
    fingerprint "$1" "$BUILD/release/tools/aqorb_fingerprint"
}

row_debian12() { disabled debian12 ''; }

# debian FOLDER RELEASE PACKAGES OPTION...: the packages of a Debian in a folder of its own, by mmdebstrap; made once.
debian() {
    need mmdebstrap
    [[ ! -e $1.complete ]] || return 0
    rm -rf "$1"
    mkdir -p "$(dirname "$1")"
    mmdebstrap --quiet --include="${3// /,}" "${@:4}" "$2" "$1" "$(mirror)"
    touch "$1.complete"
}

row_debian13() {
    local system=$CACHE/debian13 data=${OPENCV_TEST_DATA_PATH:-$ROOT/samples} inside
    need bubblewrap
    debian "$system" trixie "${PACKAGES[build]} ${PACKAGES[test]}" --variant=minbase \
        --customize-hook='mkdir "$1"/aqorb "$1"/data'
    mkdir -p "$FOLDER/debian13"
    inside=(bwrap --bind "$system" / --proc /proc --dev /dev --bind "$ROOT" /aqorb
        --bind "$FOLDER/debian13" /aqorb/build --ro-bind "$data" /data
        --setenv CCACHE_DIR /aqorb/build/ccache --unsetenv AQORB_TEST_SEQUENCE
        ${OPENCV_TEST_DATA_PATH:+--setenv OPENCV_TEST_DATA_PATH /data})
    "${inside[@]}" bash -c "source /aqorb/scripts/common.sh; bytes_only=$bytes_only; $(declare -f built); built release"
    fingerprint debian13 "${inside[@]}" --chdir "/data/${images[0]:+$photographs}" \
        /aqorb/build/release/tools/aqorb_fingerprint
}

# released 4|5
released() {
    [[ $bytes_only && -e $BUILD/opencv-$1/OpenCVConfig.cmake ]] || "$ROOT/scripts/opencv.sh" --release "$1"
    compiled "opencv$1"
    [[ $bytes_only ]] || ctest --test-dir "$BUILD/opencv$1" --output-on-failure -R '^Aqorb_Package\.(install|readme)$'
}

row_opencv4() { released 4; }
row_opencv5() { released 5; }

row_avx2() { disabled avx2 AVX512-SKX; }

row_sse4() { disabled sse4 FMA3,AVX,AVX2,AVX512-SKX; }

row_sse2() { disabled sse2 SSE3,SSSE3,SSE4.1,SSE4.2,POPCNT,FP16,FMA3,AVX,AVX2,AVX512-SKX; }

row_plain() {
    bytes_only=1 built release
    fingerprint plain "$BUILD/release/tools/aqorb_fingerprint" --plain
}

# Cross-built against the packages of this Debian for ARM64, which are unpacked in a folder, and run under qemu-user.
row_aarch64() {
    local sysroot=$CACHE/arm64/root triplet=aarch64-linux-gnu
    need emulation
    debian "$sysroot" "$(codename)" 'libgtest-dev libopencv-dev libstdc++-12-dev' --architectures=arm64 \
        --variant=extract --mode=chrootless --hook-dir=/usr/share/mmdebstrap/hooks/merged-usr
    # What update-alternatives would choose.
    ln -sf blas/libblas.so.3 lapack/liblapack.so.3 "$sysroot/usr/lib/$triplet/"
    compiled aarch64 qemu-aarch64-static -L "$sysroot"
}

row_clang() { need clang; compiled clang; }

bytes_only=
if [[ ${1:-} == --bytes ]]; then
    bytes_only=1
    shift
fi
rows=("$@")
((${#rows[@]})) || rows=(debian12 debian13 opencv4 opencv5 avx2 sse4 sse2 plain aarch64 clang)
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

# verdict ROW: the counts of its tests, and how many of its lines of hashes are those of the ordinary build.
verdict() {
    local counts total equal
    counts=$(grep '^[0-9]* passed, ' "$FOLDER/$1.log" | tail -n 1)
    total=$(wc -l <"$FOLDER/bytes/debian12")
    equal=$(comm -12 <(sort "$FOLDER/bytes/debian12") <(sort "$FOLDER/bytes/$1") | wc -l)
    printf '%s; bytes: %s of %s equal' "${counts:-no tests}" "$equal" "$total"
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
