#!/bin/bash
# Measures AdaptiveQuadtreeORB against cv::ORB with OpenCV's performance harness and prints one table
# of ratios. Where it is first run it installs what is missing and builds the harness, opencv_ts.

. "$(dirname "$0")/common.sh"

usage() {
    cat <<'END'
usage: scripts/perf.sh [--smoke] [--passes N] [--threads "1 2"] [HARNESS OPTION ...]

  --smoke        one sample of each case: shows that everything runs, measures nothing
  --passes N     how often everything is measured; the table holds medians over the passes (5)
  --threads "T"  numbers of threads to measure with ("1 2")
  others         are passed to the harness, for example --gtest_param_filter='*leuven*' or
                 --perf_min_samples=30 --perf_force_samples=30

Photographs are measured where OPENCV_TEST_DATA_PATH names the testdata folder of opencv_extra.
END
}

smoke=()
passes=5
samples=11  # odd and below 13, so that the harness's median is that of all samples, outliers included
threads='1 2'
harness_options=()
while (($#)); do
    case $1 in
        --smoke) smoke=(--smoke) passes=1 samples=1 ;;
        --passes) passes=${2:?} && shift ;;
        --threads) threads=${2:?} && shift ;;
        -h | --help) usage && exit ;;
        *) harness_options+=("$1") ;;
    esac
    shift
done

need g++ make cmake ccache python3 libopencv-dev
opencv_source

folder=$BUILD/perf
results=$folder/results
say 'Building'
mkdir -p "$folder"
{
    cmake -S "$ROOT/tools/opencv_ts" -B "$folder" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DOPENCV_SOURCE_DIR="$OPENCV_SOURCE" &&
        build "$folder" --target opencv_perf_aqorb
} >"$folder/build.log" 2>&1 || { tail -n 40 "$folder/build.log" && die 'the build failed'; }

rm -rf "$results"
mkdir -p "$results"
for ((pass = 1; pass <= passes; pass++)); do
    # shellcheck disable=SC2086  # the list of numbers is to be split
    for count in $threads; do
        say "Measuring: pass $pass of $passes, $count thread(s)"
        # The harness would take absent data and sanity records of its own for errors: they go to the log.
        "$folder/opencv_perf_aqorb" --perf_threads="$count" --perf_min_samples="$samples" \
            --perf_force_samples="$samples" "${harness_options[@]}" \
            --gtest_output="xml:$results/$pass-$count.xml" >"$results/$pass-$count.log" 2>&1 ||
            { tail -n 40 "$results/$pass-$count.log" && die 'the performance tests failed'; }
    done
done

say 'Results'
"$PYTHON" "$ROOT/tools/report/perf_table.py" "${smoke[@]}" "$results"/*.xml
