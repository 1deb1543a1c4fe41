#!/usr/bin/env bash
# Measures what doc/performance.md shows, and prints its tables.
#
#   scripts/performance.sh [OPTION ...] [PART ...] [-- HARNESS OPTION ...]
#
# PARTs, all unless named:
#   setting       the versions and the CPU features in use
#   program       AdaptiveQuadtreeORB against cv::ORB on photographs, as a program sees it that does other work, too
#   pairs         two images to a homography: cv::ORB with cv::BFMatcher against ours; needs OPENCV_TEST_DATA_PATH
#   matching      HammingMatcher against cv::BFMatcher, with and without the newer instructions of the CPU
#   collection    many images in Python: on one thread, on two, and in two processes
#   speed         AdaptiveQuadtreeORB against cv::ORB on photographs and drawn scenes
#   scaling       how the time grows with the size of the image and with the number of features
#   stages        where the time of a frame goes
#   memory        the heap in use during a frame and between frames
#   instructions  the instructions of a frame by stage and function, counted by valgrind
#   aarch64       the instructions of a frame on an emulated AArch64 CPU; only where it is named
#
# OPTIONs:
#   --doc          put the tables into doc/performance.md, too
#   --smoke        show that everything runs, in a short time; the numbers mean nothing
#   --quick        program measures a few images and numbers only, in less than half a minute
#   --beside FILE  program and memory measure another build of the library, too: FILE is its libaqorb.so
#   --passes N     how often program, speed and scaling are measured; the tables hold medians over the passes (5)
#   --threads "T"  the numbers of threads of program and speed ("1 2")
#
# speed and scaling are measured by OpenCV's performance harness, opencv_perf_aqorb. HARNESS OPTIONs go to it,
# for example --gtest_param_filter='*leuven*'. Photographs are measured where OPENCV_TEST_DATA_PATH names the folder
# testdata of opencv_extra. Installs the Debian packages it needs. The results are left in build/performance. With
# real-time priority, other programs disturb the measurement less: chrt -f 1 scripts/performance.sh
source "$(dirname "$0")/common.sh"

doc='' smoke='' quick='' beside='' passes=5 threads='1 2'
samples=11  # odd and below 13, so that the harness's median is that of all samples, outliers included
parts=()
while (($#)); do
    case $1 in
        -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit ;;
        --doc) doc=yes ;;
        --smoke) smoke=yes passes=1 samples=1 ;;
        --quick) quick=yes ;;
        --beside) beside=$(realpath -e "${2:?is the file of a library}") && shift ;;
        --passes) passes=${2:?is the number of passes} && shift ;;
        --threads) threads=${2:?are the numbers of threads} && shift ;;
        setting | program | pairs | matching | collection | speed | scaling | stages | memory | instructions | aarch64) parts+=("$1") ;;
        --) shift && break ;;
        *) die "$1 is neither an option nor a PART; --help lists them" ;;
    esac
    shift
done
harness_options=("$@")
[[ $passes =~ ^[1-9][0-9]*$ ]] || die "--passes $passes: at least 1 is accepted"
[[ ! $doc || ! $smoke ]] || die '--doc: a smoke run measures nothing for a document'
[[ ! $doc || ! $quick${harness_options[*]} ]] || die '--doc: the tables of the document are of all cases'
((${#parts[@]})) || parts=(setting program pairs matching collection speed scaling stages memory instructions)

need build report

results=$BUILD/performance
report=$ROOT/tools/report/report.py

harness='' profiler='' matching='' package=''
for part in "${parts[@]}"; do
    case $part in
        speed | scaling) harness=$BUILD/perf/opencv_perf_aqorb ;;
        aarch64) ;;
        collection) package=$BUILD/release/bindings/python ;;
        pairs | matching) matching=$BUILD/release/tools/matching/aqorb_matching ;;
        *) profiler=$BUILD/release/tools/profile/aqorb_profile ;;
    esac
done

say 'Building'
if [[ $harness ]]; then
    opencv_source
    forget_moved "$BUILD/perf" "$ROOT/tools/opencv_ts"
    cmake -S "$ROOT/tools/opencv_ts" -B "$BUILD/perf" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DOPENCV_SOURCE_DIR="$OPENCV_SOURCE"
    build "$BUILD/perf" --target opencv_perf_aqorb
fi
if [[ $profiler || $matching ]]; then
    configure "$BUILD/release" -DAQORB_BUILD_PROFILE=ON
    build "$BUILD/release" --target ${profiler:+aqorb_profile} ${matching:+aqorb_matching aqorb_preload}
fi

if [[ $package ]]; then
    need python
    configure "$BUILD/release" -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON"
    build "$BUILD/release" --target _aqorb
fi

# run_harness PART THREADS [OPTION ...]: measures a part in each pass with each number of threads.
run_harness() {
    local part=$1 numbers=$2 pass count file
    for ((pass = 1; pass <= passes; pass++)); do
        for count in $numbers; do
            say "Measuring $part: pass $pass of $passes, $count thread(s)"
            file=$results/$part/$pass-$count
            # The harness reports absent photographs and missing records of earlier runs as errors, so its output
            # goes to the log.
            "$harness" --perf_threads="$count" --perf_min_samples="$samples" --perf_force_samples="$samples" \
                "${@:3}" "${harness_options[@]}" --gtest_output="xml:$file.xml" >"$file.log" 2>&1 ||
                { tail -n 40 "$file.log" && die "the performance tests failed, see $file.log"; }
        done
    done
}

# run_profiler PART [OPTION ...]: makes a part's CSV.
run_profiler() {
    say "Measuring $1"
    "$profiler" "--$1" ${smoke:+--smoke} "${@:2}" >"$results/$1/$1.csv"
}

# Instructions that OpenCV and this module leave out: none, AVX-512, and all that not every x86-64 CPU has.
WITHOUT_AVX512=AVX512-SKX
BASELINE=SSE3,SSSE3,SSE4.1,SSE4.2,POPCNT,FP16,FMA3,AVX,AVX2,AVX512-SKX

# measure_matching NAME DISABLED [OPTION ...]: makes a CSV.
measure_matching() {
    OPENCV_CPU_DISABLE=$2 "$matching" "${@:3}" >"$results/$part/$1.csv" 2>"$results/$part/$1.log"
}

measure_matchers() {
    local options=(--repeats=11) pass cpu disabled
    [[ ! $smoke ]] || options=(--repeats=1 --n=100)
    say 'Measuring matching'
    measure_matching frequency '' --frequency
    measure_matching matchers-best '' --matchers "${options[@]}"
    measure_matching matchers-avx2 $WITHOUT_AVX512 --matchers "${options[@]}"
    measure_matching matchers-baseline $BASELINE --matchers "${options[@]}"
    for pass in 1 2 3; do
        for cpu in best avx2; do
            disabled=
            [[ $cpu == best ]] || disabled=$WITHOUT_AVX512
            measure_matching "program-$cpu-$pass" "$disabled" --program --bytes=64 --repeats=5 "${options[@]:1}"
            LD_PRELOAD=$BUILD/release/bindings/preload/libaqorb_preload.so \
                measure_matching "preloaded-$cpu-$pass" "$disabled" --program --bytes=64 --repeats=5 "${options[@]:1}"
        done
    done
    measure_matching scaling '' --scaling --repeats=31 --n=1000,2000,5000,10000 "${options[@]:1}"
}

measure_pairs() {
    local options=('--n=1000,2000' --repeats=11)
    [[ ! $smoke ]] || options=(--n=100 --repeats=1)
    say 'Measuring pairs of images'
    measure_matching pairs-best '' --pairs "${options[@]}"
    measure_matching pairs-avx2 $WITHOUT_AVX512 --pairs "${options[@]}"
}

measure_collection() {
    local options=()
    [[ ! $smoke ]] || options=(--images=20 --repeats=1)
    say 'Measuring collections of images'
    PYTHONPATH=$package PYTHONDONTWRITEBYTECODE=1 "$PYTHON" "$ROOT/tools/profile/collection.py" "${options[@]}" \
        >"$results/collection/collection.csv"
}

# run_frames PART PROGRAM FRAMES [OPTION ...]: makes a part's CSV of single frames.
run_frames() {
    local frames=$3 images=640x480,1920x1080
    if [[ $smoke ]]; then
        images=320x240 frames=1
    elif [[ ${OPENCV_TEST_DATA_PATH:-} && $1 == stages ]]; then
        images+=,bikes,leuven,bark,trees,ubc,640x512.png,1920x1080.png
    elif [[ ${OPENCV_TEST_DATA_PATH:-} ]]; then
        images+=,leuven,bark
    fi
    say "Measuring $1"
    "$PYTHON" "$ROOT/tools/profile/frames.py" "$1" "$2" --images="$images" --frames="$frames" --out="$results/$1" \
        "${@:4}" >"$results/$1/$1.csv"
}

measure_aarch64() {
    local plugin=$results/aarch64/qemu_count.so
    need count
    qemu-aarch64 --help | grep -q -e -plugin || die 'aarch64: this qemu-aarch64 has no plugins'
    say 'Building for AArch64'
    sysroot arm64
    configure aarch64 -DAQORB_BUILD_PROFILE=ON
    build "$BUILD/aarch64" --target aqorb_profile
    cc -O2 -fPIC -shared "$ROOT/tools/profile/qemu_count.c" -o "$plugin" \
        -DQEMU_PLUGIN_VERSION="$(qemu-aarch64 --version | awk '/version/ { print ($3 + 0 < 9 ? 1 : 2) }')"
    run_frames aarch64 "$BUILD/aarch64/tools/profile/aqorb_profile" 2 \
        --plugin="$plugin" --sysroot="$SYSROOT"
}

for part in "${parts[@]}"; do
    if [[ $part == pairs && ! ${OPENCV_TEST_DATA_PATH:-} ]]; then
        say 'Pairs of images are left out: OPENCV_TEST_DATA_PATH is not set'
        continue
    fi
    rm -rf "${results:?}/$part"
    mkdir -p "$results/$part"
    case $part in
        speed) run_harness speed "$threads" --gtest_filter='Features_*' ;;
        scaling) run_harness scaling 1 --gtest_filter='Scaling_*' ;;
        stages) run_frames stages "$profiler" 31 ;;
        instructions) need valgrind; run_frames instructions "$profiler" 3 ;;
        program) run_profiler program ${quick:+--quick} ${beside:+--beside="$beside"} \
            --passes="$passes" --threads="${threads// /,}" ;;
        memory) run_profiler memory ${beside:+--beside="$beside"} ;;
        aarch64) measure_aarch64 ;;
        matching) measure_matchers ;;
        pairs) measure_pairs ;;
        collection) measure_collection ;;
        *) run_profiler "$part" ;;
    esac
    [[ ! $smoke ]] || say 'SMOKE RUN: it shows that everything runs. Do not quote these numbers.'
    "$PYTHON" "$report" "$part" "$results/$part"
done

# At the end, so that a document changes only if everything was measured.
if [[ $doc ]]; then
    say 'Updating the document'
    for part in "${parts[@]}"; do
        [[ -d $results/$part ]] || continue
        "$PYTHON" "$report" "$part" "$results/$part" --doc "$ROOT/doc/performance.md"
    done
fi
