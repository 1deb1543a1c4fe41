#!/usr/bin/env bash
# Fuzzes the library with libFuzzer under the address and undefined-behaviour sanitizers; see
# doc/reliability.md. Ends with status 0 if nothing was found.
source "$(dirname "$0")/common.sh"

usage() {
    cat <<'END'
usage: scripts/fuzz.sh [--smoke | --seconds N] [--coverage] [fuzz_api | fuzz_reference ...]

  TARGET       both, side by side, unless named
  --seconds N  how long (60)
  --smoke      25 seconds, from the repository's corpus alone: shows that the targets run, and that known
               inputs do no harm
  --coverage   also prints how much of the library's source the corpus covers, and what becomes of the
               inputs of fuzz_api when cv::ORB gets them

Finds, logs and new inputs are kept in build/fuzz-run; the next run goes on from there. build/fuzz-smoke has
those of --smoke.
END
}

run=$BUILD/fuzz-run
seconds=60 coverage=0 targets=()
while (($#)); do
    case $1 in
        --smoke) seconds=25 run=$BUILD/fuzz-smoke ;;
        --seconds) seconds=${2:?} && shift ;;
        --coverage) coverage=1 ;;
        fuzz_api | fuzz_reference) targets+=("$1") ;;
        -h | --help) usage && exit ;;
        *) usage >&2 && exit 2 ;;
    esac
    shift
done
((${#targets[@]})) || targets=(fuzz_api fuzz_reference)

need clang libclang-rt-14-dev llvm cmake make ccache libopencv-dev libgtest-dev

max_length=4096
export ASAN_OPTIONS=detect_stack_use_after_return=1 UBSAN_OPTIONS=print_stacktrace=1

# configure_fuzzers FOLDER [OPTION...]
configure_fuzzers() {
    configure "$1" -DCMAKE_CXX_COMPILER=clang++ -DAQORB_BUILD_FUZZERS=ON -DAQORB_BUILD_TESTS=OFF \
        -DAQORB_BUILD_SAMPLES=OFF -DAQORB_BUILD_PRELOAD=OFF -DAQORB_INSTALL=OFF "${@:2}" >/dev/null
}

[[ $run != *smoke ]] || rm -rf "$run"

say "Building"
configure_fuzzers "$BUILD/fuzz"
build "$BUILD/fuzz" --target "${targets[@]}"

# fuzz TARGET: from the repository's corpus and what earlier runs have found.
fuzz() {
    local target=$1 corpus=$run/$1/corpus
    mkdir -p "$corpus" "$run/$target/finds"
    "$BUILD/fuzz/tools/fuzz/$target" "$corpus" "$ROOT/tools/fuzz/corpus/$target" \
        -artifact_prefix="$run/$target/finds/" -max_total_time="$seconds" -max_len=$max_length -timeout=60 \
        -rss_limit_mb=3072 -malloc_limit_mb=1024 -print_final_stats=1 >"$run/$target/log" 2>&1
}

say "Fuzzing ${targets[*]} for $seconds s"
mkdir -p "$run"
pids=() status=0
trap 'kill "${pids[@]}" 2>/dev/null || true' EXIT
for target in "${targets[@]}"; do
    mkdir -p "$run/$target"
    fuzz "$target" &
    pids+=($!)
done
declare -A failed=()
for i in "${!targets[@]}"; do
    wait "${pids[i]}" || { failed[${targets[i]}]=1 && status=1; }
done
trap - EXIT

say "Results"
for target in "${targets[@]}"; do
    log=$run/$target/log
    if [[ -n ${failed[$target]:-} ]]; then
        tail -n 60 "$log"
        echo "$target: a find; its input is the newest file of ${run#"$ROOT"/}/$target/finds"
        continue
    fi
    executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    covered=$(grep -oE 'cov: [0-9]+ ft: [0-9]+ corp: [0-9]+' "$log" | tail -n 1)
    echo "$target: $executions executions, no find; libFuzzer's $covered"
done
((status == 0)) || exit $status

say "The corpus on the other kernels"
# The best kernels but one; the baseline is what fuzz_reference compares with.
for target in "${targets[@]}"; do
    OPENCV_CPU_DISABLE=AVX512-SKX "$BUILD/fuzz/tools/fuzz/$target" -runs=0 -max_len=$max_length \
        "$run/$target/corpus" "$ROOT/tools/fuzz/corpus/$target" >"$run/$target/kernels.log" 2>&1 ||
        { tail -n 40 "$run/$target/kernels.log" && die "$target: a find without AVX-512"; }
    echo "$target: no find without AVX-512"
done

if ((coverage)); then
    say "Source coverage by the corpus"
    folder=$BUILD/fuzz-coverage
    configure_fuzzers "$folder" -DAQORB_FUZZ_COVERAGE=ON
    build "$folder" --target "${targets[@]}" fuzz_orb
    profiles=()
    for target in "${targets[@]}"; do
        LLVM_PROFILE_FILE=$run/$target/profile "$folder/tools/fuzz/$target" -runs=0 -max_len=$max_length \
            "$run/$target/corpus" "$ROOT/tools/fuzz/corpus/$target" >"$run/$target/coverage.log" 2>&1
        profiles+=("$run/$target/profile")
    done
    llvm-profdata merge "${profiles[@]}" -o "$run/profile"
    llvm-cov report -instr-profile="$run/profile" "$folder/modules/aqorb/libaqorb.so" \
        --ignore-filename-regex='/usr/' --show-region-summary=false | tee "$run/coverage" |
        grep -E '^Filename|^TOTAL'

    say "The inputs of fuzz_api, given to cv::ORB"
    "$folder/tools/fuzz/fuzz_orb" "$ROOT/tools/fuzz/corpus/fuzz_api" "$run/fuzz_api/corpus"
fi
