#!/usr/bin/env bash
# Compares the Python package with other ORB detectors that pip installs: cv2.ORB of OpenCV 4 and 5, kornia-rs and
# scikit-image. All of them find 1000 keypoints in the same images, in one run. With AQORB_TEST_SEQUENCE, a sequence in
# the layout of KITTI's odometry with its poses, it also compares matchers, those of kornia-rs, faiss and FLANN among
# them, and the way from two views to their pose.
#
#   scripts/peers.sh WHEEL
#
# WHEEL is the package's, from scripts/wheel.sh, for Debian's python3. OPENCV_TEST_DATA_PATH names the folder testdata
# of opencv_extra. Prints a table, and leaves it in build/peers/table.md and a picture in build/peers/peers.jpg.
#
# The number of threads is that of the processors that a detector may use.
source "$(dirname "$0")/common.sh"

(($# == 1)) || die "name one wheel; --help says more"
[[ -d ${OPENCV_TEST_DATA_PATH:-} ]] || die "OPENCV_TEST_DATA_PATH does not name a folder"
need wheel util-linux
wheel=$(realpath "$1")
data=$OPENCV_TEST_DATA_PATH/cv/detectors_descriptors_evaluation/images_datasets
folder=$BUILD/peers
mkdir -p "$folder"

say "Installing"
environment "$BUILD/venv/peers$OPENCV_4" "opencv-python-headless==$OPENCV_4" "$wheel" kornia-rs scikit-image faiss-cpu
environment "$BUILD/venv/peers$OPENCV_5" "opencv-python-headless==$OPENCV_5" "$wheel"

methods=(aqorb aqorb-arrays cv2-4 cv2-5 kornia kornia-fewer scikit)
for method in "${methods[@]}"; do
    say "$method"
    version=$OPENCV_4
    [[ $method != cv2-5 ]] || version=$OPENCV_5
    python=$BUILD/venv/peers$version/bin/python
    "$python" "$ROOT/tools/peers/peers.py" features "$method" "$data" "$folder"
    for processors in 0 0,1; do
        taskset -c "$processors" "$python" "$ROOT/tools/peers/peers.py" time "$method" "$data" "$folder"
    done
done

say "Table"
"$BUILD/venv/peers$OPENCV_4/bin/python" "$ROOT/tools/peers/peers.py" report "$data" "$folder" "${methods[@]}" |
    tee "$folder/table.md"

[[ ${AQORB_TEST_SEQUENCE:-} ]] || exit 0
for table in matchers views; do
    say "$table, one processor"
    taskset -c 0 "$BUILD/venv/peers$OPENCV_4/bin/python" "$ROOT/tools/peers/matching.py" "$table" "$AQORB_TEST_SEQUENCE" |
        tee "$folder/$table.md"
done
