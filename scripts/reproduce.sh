#!/usr/bin/env bash
# Measures the paper's tables and figures, and more, anew: see doc/reproduction.md.
#
#   scripts/reproduce.sh [--doc] DATASETS [OPTION ...]
#
# DATASETS holds the folders bikes, leuven, bark, trees, ubc and graf of the Oxford data (img1..6 and
# homographies), for example opencv_extra's testdata/cv/detectors_descriptors_evaluation/images_datasets.
# Options go to aqorb_evaluate: --odometry=SEQUENCE (KITTI's layout), --superpoint=MODEL.onnx, others by --help;
# they take precedence over those below. Installs the Debian packages it needs. Writes to build/reproduction, with
# --doc the tables and some of the figures to doc/, too.
source "$(dirname "$0")/common.sh"

doc=
if [[ ${1:-} == --doc ]]; then doc=yes && shift; fi
(($# > 0)) || die "which DATASETS? See the head of this script."
need build evaluate report

folder=$BUILD/reproduction
configure "$BUILD/release" -DAQORB_BUILD_EVALUATION=ON
build "$BUILD/release" --target aqorb_evaluate
rm -rf "$folder"
mkdir -p "$folder"

say "Measuring"
"$BUILD/release/tools/evaluate/aqorb_evaluate" "$1" --out="$folder" --sets=bikes,leuven,bark,trees,ubc,graf \
    --n=500,1000,2000 --degrade=dark,gamma,noise --ablation "${@:2}"

say "Making tables and figures"
"$PYTHON" "$ROOT/tools/report/report.py" evaluation "$folder" >"$folder/tables.txt"
"$PYTHON" "$ROOT/tools/report/report.py" figures "$folder"

if [[ $doc ]]; then
    "$PYTHON" "$ROOT/tools/report/report.py" evaluation "$folder" --doc "$ROOT/doc/reproduction.md"
    for figure in figure3.jpg figure6.png figure8.png; do
        cp "$folder/$figure" "$ROOT/doc/images/reproduction-$figure"
    done
fi

say "Results"
cat "$folder/tables.txt"
echo
echo "In $folder: tables.txt, the figures and the CSV files that both were made of."
