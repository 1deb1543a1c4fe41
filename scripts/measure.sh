#!/usr/bin/env bash
# Measures what the documents' tables show, and prints them in Markdown, to be pasted.
#
#   scripts/measure.sh speed [OPTION ...]     beside cv::ORB, cv::BFMatcher and Lucas-Kanade (doc/performance.md)
#   scripts/measure.sh paper [OPTION ...]     the paper's tables and Figures 3, 6 and 8 (doc/reproduction.md)
#   scripts/measure.sh claims [OPTION ...]    what is claimed of the selection (doc/reproduction.md)
#   scripts/measure.sh refinement [OPTION ...]  what refineMatches gives (doc/reproduction.md)
#   scripts/measure.sh poses [4|5] [OPTION ...]  relative poses, by OpenCV and PoseLib (doc/reproduction.md)
#   scripts/measure.sh objects [4|5] [OPTION ...]  known objects located in scenes (the tutorial on finding them)
#   scripts/measure.sh reconstruction         by COLMAP, also from SIFT (photographs/reconstruction.md)
#   scripts/measure.sh verdict [OPTION ...]   places of images of different things (photographs/many_images.md)
#   scripts/measure.sh readme                 README's table but for objects and reconstructions, in some ten minutes
#   scripts/measure.sh heldout                fetches the pairs of images that nothing was tuned on, for claims
#
# OPENCV_TEST_DATA_PATH names the folder testdata of opencv_extra; speed draws scenes without it. paper, claims,
# refinement, poses, objects and verdict pass OPTIONs on to tools/evaluate/aqorb_evaluate.py, whose --help lists them.
# AQORB_TEST_SEQUENCE, a sequence in KITTI's layout with its poses, adds the start with one camera to claims, and a
# table to poses.
#
# poses and objects take Debian's cv2, or with 4 or 5 that of the Python package index. They and verdict fetch two scenes
# of Strecha's photographs unless AQORB_STRECHA names a clone of github.com/openMVG/SfM_quality_evaluation.
#
# speed runs the performance tests of perf/ in OpenCV's own harness, for this module and for OpenCV, with 1 and 2
# threads, and without AVX-512 where there is AVX-512. The harness takes the OPTIONs: --gtest_filter=Matching* measures a
# part. OpenCV's summary of its XML files, in build/perf, prints the tables. aqorb_benchmark then measures in turns what
# the harness cannot. --smoke shows in a short time that all runs; the numbers mean nothing.
#
# Installs the Debian packages, and fetches the images and Python packages, that it needs. paper leaves the figures in
# build/paper.
source "$(dirname "$0")/common.sh"

datasets=${OPENCV_TEST_DATA_PATH:-}/cv/detectors_descriptors_evaluation/images_datasets

photographs() { [[ -d $datasets ]] || die 'OPENCV_TEST_DATA_PATH must name the folder testdata of opencv_extra'; }

# harness NAME OPTION...: runs the tests of perf/. The harness reports absent records of earlier runs as errors.
harness() {
    "$BUILD/perf/opencv_perf_aqorb" "${@:2}" "${options[@]}" "--gtest_output=xml:$BUILD/perf/$1.xml" \
        >"$BUILD/perf/$1.log" || true
}

# summary NAME: the table of OpenCV's times and of another run's.
summary() {
    "$PYTHON" "$OPENCV_SOURCE/modules/ts/misc/summary.py" --output=markdown --metric=median \
        "$BUILD/perf"/{opencv,"$1"}.xml
}

speed() {
    local options=(--perf_time_limit=0.5 "$@") turns=31 images=() disabled threads option sets=('')
    local benchmark=$BUILD/release/tools/aqorb_benchmark
    [[ -d $datasets ]] || images=(640x480)
    if [[ ${1:-} == --smoke ]]; then
        options=(--perf_min_samples=1 --perf_force_samples=1 '--gtest_filter=*320x240*:*500*') turns=1
    elif grep -q avx512bw /proc/cpuinfo; then
        sets+=(AVX512-SKX)
    fi
    need build python3
    opencv_source
    configure release -DAQORB_BUILD_BENCHMARK=ON
    build "$BUILD/release" --target aqorb_benchmark aqorb_preload
    configure_beside perf "$ROOT/tools/opencv_ts"
    build "$BUILD/perf" --target opencv_perf_aqorb

    for disabled in "${sets[@]}"; do
        export OPENCV_CPU_DISABLE=$disabled
        for threads in 1 2; do
            harness opencv --perf_impl=opencv --perf_threads="$threads"
            harness aqorb --perf_threads="$threads"
            say "Threads: $threads${disabled:+, without $disabled}"
            summary aqorb
        done
        LD_PRELOAD=$BUILD/release/preload/libaqorb_preload.so harness preloaded --perf_impl=opencv
        harness opencv --perf_impl=opencv
        say "With the library preloaded${disabled:+, without $disabled}"
        summary preloaded
        say "In turns${disabled:+, without $disabled}"
        for option in --threads=1 --threads=2 --cold --busy=1; do
            echo "$option"
            "$benchmark" frames --turns="$turns" $option "${images[@]}"
        done
    done
}

evaluate() {
    need build python python3-matplotlib
    configure release -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON"
    build "$BUILD/release" --target _aqorb
    say "Measuring; README's table takes some ten minutes, the others up to hours" >&2
    PYTHONPATH=$BUILD/release/python PYTHONDONTWRITEBYTECODE=1 \
        "$PYTHON" "$ROOT/tools/evaluate/aqorb_evaluate.py" "$1" "${@:2}"
}

claims() {
    local data=(--object="$OPENCV_TEST_DATA_PATH/cv/shared")
    [[ ! ${AQORB_TEST_SEQUENCE:-} ]] || data+=(--sequence="$AQORB_TEST_SEQUENCE")
    [[ ! -e $CACHE/held_out/complete ]] || data+=(--heldout="$CACHE/held_out")
    evaluate claims "$datasets" "${data[@]}" "$@"
}

scenes() {
    strecha fountain-P11 entry-P10 || die "could not fetch the photographs; is there a network?"
    export AQORB_STRECHA
}

# in_python SUBJECT [OPTION ...]: poses or reconstruction.
in_python() { scenes && "$ROOT/scripts/python.sh" "$@"; }

# located SUBJECT [OPTION ...]: objects or verdict.
located() {
    scenes
    opencv_samples
    export OPENCV_SAMPLES_DATA_PATH=$OPENCV_SAMPLES
    "$ROOT/scripts/python.sh" "$@"
}

readme() {
    scenes
    evaluate readme "$AQORB_STRECHA/Benchmarking_Camera_Calibration_2008"
}

# Unpacks the packages of tools/evaluate/held_out.csv without installing them.
heldout() {
    local folder=$CACHE/held_out package
    opencv_source
    tools pip
    if [[ ! -e $folder/complete ]]; then
        say "Fetching the packages of the held-out images"
        rm -rf "$folder"
        mkdir -p "$folder"
        for package in visp-images-data octave-vlfeat; do
            debian_file "$package" "$folder"
            dpkg-deb -x "$folder/$package"_*.deb "$folder/$package"
        done
        "$TOOLS/python" -m pip install --quiet --no-deps --require-hashes --target "$folder/wheels" \
            --requirement /dev/stdin <<'PACKAGES' || die "could not fetch from the Python package index; is there a network?"
image-matching-models==1.1.0 --hash=sha256:48503a972801714afc9b477e6819b06e40ec62e09afc74b34916d0335e1d2bd4
stereodemo==0.7 --hash=sha256:effd07da657295e834aa1b0c89cc962e953d66b506a75365ad32a1114f2389ec
PACKAGES
        ln -sfn "$OPENCV_SOURCE" "$folder/opencv"
        touch "$folder/complete"
    fi
}

case ${1:-} in
paper | claims | refinement | objects | verdict) photographs ;;
esac
case ${1:-} in
speed | readme | heldout | claims) "$@" ;;
poses | reconstruction) in_python "$@" ;;
objects | verdict) located "$@" ;;
paper) evaluate paper "$datasets" --out="$BUILD/paper" "${@:2}" ;;
refinement) evaluate refinement "$datasets" "${@:2}" ;;
*) die "'${1:-}' is none of speed, paper, claims, refinement, readme, poses, objects, verdict, reconstruction, heldout; --help says more" ;;
esac
