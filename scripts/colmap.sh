#!/usr/bin/env bash
# Reconstructs a scene with COLMAP from features of the Python package, of cv2.ORB and of SIFT, by the sample
# samples/colmap/colmap.py.
#
#   scripts/colmap.sh WHEEL FOLDER [option of colmap.py ...]
#
# WHEEL is the package's, from scripts/wheel.sh, for Debian's python3. FOLDER has the folder image_0 (or image_l),
# calib.txt and poses.txt, as the odometry benchmark of KITTI has them. Prints a table, and leaves the reconstructions
# in build/colmap.
source "$(dirname "$0")/common.sh"

(($# >= 2)) || die "name a wheel and a folder; --help says more"
need wheel
wheel=$(realpath "$1")
folder=$(realpath "$2")
environment "$BUILD/venv/colmap" "opencv-python-headless==$OPENCV_4" "pycolmap==$PYCOLMAP" "$wheel"
"$BUILD/venv/colmap/bin/python" "$ROOT/samples/colmap/colmap.py" --out="$BUILD/colmap" "${@:3}" "$folder"
