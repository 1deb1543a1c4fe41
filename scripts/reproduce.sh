#!/usr/bin/env bash
# Measures the paper's tables and figures again, what the paper did not measure, and what is claimed of the selection:
# see doc/reproduction.md.
#
#   scripts/reproduce.sh [--doc] DATASETS [OPTION ...]
#
# DATASETS holds the folders bikes, leuven, bark, trees, ubc and graf of the Oxford data (img1..6 and
# homographies), for example opencv_extra's testdata/cv/detectors_descriptors_evaluation/images_datasets. Options go to
# aqorb_evaluate, whose --help lists them, for example --odometry=SEQUENCE (KITTI's layout) and --superpoint=MODEL.onnx.
# --odometry and --seeds go to aqorb_claims, too. Options that you give take precedence over those of this script.
# Installs the Debian packages and fetches the images it needs. Writes to build/reproduction. With --doc it also writes
# the tables and some of the figures to doc.
source "$(dirname "$0")/common.sh"

doc=
if [[ ${1:-} == --doc ]]; then doc=yes && shift; fi
(($# > 0)) || die "which DATASETS? See the head of this script."
need build evaluate report

folder=$BUILD/reproduction
configure "$BUILD/release" -DAQORB_BUILD_EVALUATION=ON
build "$BUILD/release" --target aqorb_evaluate aqorb_claims
opencv_samples
"$ROOT/scripts/held_out.sh"
rm -rf "$folder"
mkdir -p "$folder"

say "Measuring"
"$BUILD/release/tools/evaluate/aqorb_evaluate" "$1" --out="$folder" --sets=bikes,leuven,bark,trees,ubc,graf \
    --n=500,1000,2000 --degrade=dark,gamma,noise --ablation "${@:2}"

say "Measuring what is claimed of the selection"
claims=()
for option in "${@:2}"; do
    case $option in
    --odometry=*) claims+=("--stereo=${option#*=}") ;;
    --seeds=*) claims+=("$option") ;;
    esac
done
status=0
"$BUILD/release/tools/evaluate/aqorb_claims" "$1" --object="$OPENCV_SAMPLES" --heldout="$BUILD/held_out" \
    --out="$folder" "${claims[@]}" >"$folder/claims.txt" || status=$?
((status == 0 || status == 3)) || die "aqorb_claims failed"

say "Making tables and figures"
"$PYTHON" "$ROOT/tools/report/report.py" evaluation "$folder" >"$folder/tables.txt"
"$PYTHON" "$ROOT/tools/report/report.py" claims "$folder" >>"$folder/tables.txt"
"$PYTHON" "$ROOT/tools/report/report.py" figures "$folder"

if [[ $doc ]]; then
    "$PYTHON" "$ROOT/tools/report/report.py" evaluation "$folder" --doc "$ROOT/doc/reproduction.md"
    "$PYTHON" "$ROOT/tools/report/report.py" claims "$folder" --doc "$ROOT/doc/reproduction.md"
    for figure in figure3.jpg figure6.png figure8.png; do
        cp "$folder/$figure" "$ROOT/doc/images/reproduction-$figure"
    done
fi

say "Results"
cat "$folder/tables.txt"
echo
echo "In $folder: tables.txt, the figures and the CSV files that both were made of."
