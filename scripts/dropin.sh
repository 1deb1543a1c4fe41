#!/usr/bin/env bash
# Shows that libaqorb_preload.so replaces cv::ORB, and the function by which cv::BFMatcher matches, in programs that do
# not know of it. Runs Debian's Python binding, OpenCV's samples and OpenCV's own tests of features2d, each with and
# without the library. The samples and the tests are built from Debian's source package without a change.
#
#   scripts/dropin.sh
#
# Installs the Debian packages it needs. OpenCV's tests need OPENCV_TEST_DATA_PATH, the folder testdata of
# opencv_extra, and are left out without it. Ends with status 0 if everything is as it should be.
source "$(dirname "$0")/common.sh"

need build test python3-opencv
opencv_source
export OPENCV_SAMPLES=$OPENCV_SOURCE/samples/python OPENCV_SAMPLES_DATA_PATH=$OPENCV_SOURCE/samples/data

folder=$BUILD/dropin
preload=$BUILD/release/preload/libaqorb_preload.so
headless=$folder/libheadless.so
notice='aqorb: cv::ORB::create gives AdaptiveQuadtreeORB'
matcher_notice="aqorb: cv::batchDistance gives aqorb's Hamming distances"

say "Building"
configure release -DAQORB_BUILD_PRELOAD=ON
build "$BUILD/release" --target aqorb_preload aqorb_preload_test
configure_beside dropin "$ROOT/preload/opencv"
build "$folder"
mkdir -p "$folder/out"

say "A program of the installed OpenCV's cv::ORB"
ctest --test-dir "$BUILD/release" --tests-regex '^Aqorb_Preload' --output-on-failure --no-tests=error

say "Debian's python3-opencv"
LD_PRELOAD=$preload "$PYTHON" "$ROOT/preload/test/test_python.py"

# run LOG LIBRARIES COMMAND...: a program with libraries preloaded, in a folder where it may leave files;
# prints the log if it fails.
run() {
    local log=$1 libraries=$2 status=0
    shift 2
    (cd "$folder/out" && AQORB_VERBOSE=1 LD_PRELOAD=$libraries exec "$@") >"$log" 2>&1 || status=$?
    ((status == 0)) || { tail -n 40 "$log" && die "$(basename "$1") failed with status $status"; }
}

# compare NAME PATTERN COMMAND...: both runs must succeed, the second one with our detector; shows the lines
# that say what came out.
compare() {
    local name=$1 pattern=$2 log=$folder/out/$1
    shift 2
    run "$log.cv" "$headless" "$@"
    run "$log.aqorb" "$headless:$preload" "$@"
    if grep -q "$notice" "$log.cv"; then die "$name: interposed without the library"; fi
    grep -q "$notice" "$log.aqorb" || die "$name: not interposed"
    say "$name"
    grep -oE "$pattern" "$log.cv" | sed 's/^/cv::ORB              /'
    grep -oE "$pattern" "$log.aqorb" | sed 's/^/AdaptiveQuadtreeORB  /'
}

data=$OPENCV_SAMPLES_DATA_PATH
compare matchmethod_orb_akaze_brisk '^ORB.*' "$folder/matchmethod_orb_akaze_brisk"
compare asift '[0-9]+ / [0-9]+ +inliers.matched' "$folder/asift" --feature=orb
# The pictures of OpenCV's samples have a pair for stereo only, on which the confidence of cv::Stitcher is near its limit.
pair=("${OPENCV_TEST_DATA_PATH:-}"/cv/detectors_descriptors_evaluation/images_datasets/trees/img{1,2}.png)
if [[ -e ${pair[1]} ]]; then
    compare stitching_detailed 'Features in image.*' "$folder/stitching_detailed" \
        "${pair[@]}" --features orb --output "$folder/out/stitching_detailed.jpg"
    compare stitching '[a-z_]+\.jpg saved' "$folder/stitching" "${pair[@]}" --output "$folder/out/stitching.jpg"
fi
compare find_obj.py '[0-9]+ / [0-9]+ +inliers.matched' "$PYTHON" "$OPENCV_SAMPLES/find_obj.py" --feature=orb

say "A sample that uses another detector"
run "$folder/out/akaze" "$headless:$preload" "$PYTHON" "$OPENCV_SAMPLES/find_obj.py" --feature=akaze
if grep "$notice" "$folder/out/akaze"; then die "a notice without cv::ORB"; fi
echo "no notice"

if [[ -z ${OPENCV_TEST_DATA_PATH:-} ]]; then
    say "OpenCV's own tests are left out: OPENCV_TEST_DATA_PATH is not set"
    exit
fi

# fresh_data: points OPENCV_TEST_DATA_PATH to a copy, because OpenCV's tests write records that are missing there. Where
# a test only needs some picture, another one takes the place of a picture that is missing.
original_data=$(cd "$OPENCV_TEST_DATA_PATH" && pwd)
fresh_data() {
    export OPENCV_TEST_DATA_PATH=$folder/testdata
    rm -rf "$OPENCV_TEST_DATA_PATH"
    cp -rs "$original_data" "$OPENCV_TEST_DATA_PATH"
    [[ -e $original_data/cv/shared/lena.png ]] ||
        ln -s "$data/home.jpg" "$OPENCV_TEST_DATA_PATH/cv/shared/lena.png"
    mkdir -p "$OPENCV_TEST_DATA_PATH/stitching"
    [[ -e $original_data/stitching/s2.jpg ]] ||
        ln -s "$data/aloeL.jpg" "$OPENCV_TEST_DATA_PATH/stitching/s2.jpg"
}

# verdicts LIBRARIES: what each test of OpenCV's features2d comes to.
verdicts() {
    fresh_data
    AQORB_VERBOSE=1 LD_PRELOAD=$1 "$folder/opencv_test_features2d" >"$folder/out/tests" 2>&1 || true
    sed -nE 's/^\[ +(OK|FAILED) +\] ([^ ,]+).* \([0-9]+ ms\)$/\1 \2/p' "$folder/out/tests" | sort
}

say "OpenCV's accuracy tests of features2d: those of cv::ORB and of the matchers that it interposes"
verdicts '' >"$folder/out/verdicts.cv"
verdicts "$preload" >"$folder/out/verdicts.aqorb"
grep -q "$notice" "$folder/out/tests" || die "not interposed"
grep -q "$matcher_notice" "$folder/out/tests" || die "matching is not interposed"
grep 'ORB\|BruteForce\|DMatch' "$folder/out/verdicts.aqorb"

say "All tests whose verdict differs from that with cv::ORB"
differ=$(comm -3 --output-delimiter='with the library: ' "$folder"/out/verdicts.{cv,aqorb})
echo "$differ"
regression=Features2d_Detector_ORB.regression  # compares with stored keypoints of cv::ORB
[[ $differ == "with the library: FAILED $regression"$'\n'"OK $regression" ]] || die "other tests than this one differ"

say "OpenCV's performance tests of cv::ORB, one sample each"
fresh_data
run "$folder/out/perf" "$preload" "$folder/opencv_perf_features2d" --gtest_filter='feature2d*' \
    --gtest_param_filter='*ORB*' --perf_min_samples=1 --perf_force_samples=1 --perf_verify_sanity=0
grep -q "$notice" "$folder/out/perf" || die "not interposed"
grep PASSED "$folder/out/perf"
