#!/usr/bin/env bash
# Measures what doc/performance.md shows: speed, stages, scaling, memory, instructions.
#
#   scripts/performance.sh [--doc] [--smoke] [PART ...]
#
# PARTs are setting, perf, stages, scaling, memory and instructions; all unless named. --doc puts their tables
# into doc/performance.md; --smoke shows in seconds that everything but perf runs. Photographs are measured where
# OPENCV_TEST_DATA_PATH names the testdata folder of opencv_extra. Installs the Debian packages it needs.
# Writes to build/performance. Times are best taken with real-time priority: chrt -f 1 scripts/performance.sh
source "$(dirname "$0")/common.sh"

doc=
smoke=()
parts=()
while (($#)); do
    case $1 in
        --doc) doc=yes ;;
        --smoke) smoke=(--smoke) ;;
        setting | perf | stages | scaling | memory | instructions) parts+=("$1") ;;
        *) die "$1? See the head of this script." ;;
    esac
    shift
done
[[ ! $doc || ! ${smoke[*]} ]] || die 'a smoke run measures nothing for a document'
if ((! ${#parts[@]})); then
    parts=(setting stages scaling memory instructions)
    [[ ${smoke[*]} ]] || parts+=(perf)
fi

need build-essential cmake libopencv-dev python3 valgrind

folder=$BUILD/performance
benchmark=$BUILD/release/tools/profile/aqorb_profile
mkdir -p "$folder"
configure "$BUILD/release" -DAQORB_BUILD_PROFILE=ON
build "$BUILD/release" --target aqorb_profile

# perf_tables: what scripts/perf.sh prints, as tables under titles.
perf_tables() {
    "$ROOT/scripts/perf.sh" | tee /dev/stderr | sed -n '/^=== Results/,$p' >"$folder/perf.txt"
    "$PYTHON" "$ROOT/tools/report/perf_aims.py" "$folder/perf.txt"
    printf '## Against cv::ORB\n\n'
    grep '^|' "$folder/perf.txt"
    printf '\n## Against cv::ORB: notes\n\n|  |\n|---|\n'
    sed -n '/^$/d; /^===/d; /^|/!s/.*/| & |/p' "$folder/perf.txt"
    echo
}

images=640x480,1920x1080
frames=3
if [[ ${smoke[*]} ]]; then
    images=320x240 frames=1
elif [[ ${OPENCV_TEST_DATA_PATH:-} ]]; then
    images+=,leuven,bark
fi

for part in "${parts[@]}"; do
    say "Measuring: $part"
    case $part in
        perf) perf_tables ;;
        instructions) "$PYTHON" "$ROOT/tools/profile/instructions.py" "$benchmark" "$folder" --images="$images" \
            --frames="$frames" ;;
        *) "$benchmark" "--$part" "${smoke[@]}" ;;
    esac >"$folder/$part.md"
    cat "$folder/$part.md"
done

if [[ $doc ]]; then
    for part in "${parts[@]}"; do cat "$folder/$part.md"; done >"$folder/tables.md"
    "$PYTHON" "$ROOT/tools/report/update_doc.py" --keep "$folder" "$ROOT/doc/performance.md"
fi
