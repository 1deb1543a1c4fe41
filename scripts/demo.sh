#!/usr/bin/env bash
# Builds the module and shows what it does beside cv::ORB: a table and a picture for each pair of images.
#
#   scripts/demo.sh [--nfeatures=N] [--out=FOLDER] [IMAGE IMAGE]
#   scripts/demo.sh --images
#
# Installs the Debian packages it needs. Without images it takes three pairs of OpenCV's samples (the Debian package
# opencv-doc, fetched, not installed), and two of Strecha's photographs of a fountain, which it fetches from GitHub or
# finds in the clone that AQORB_STRECHA names. N is 1000 unless given. The pictures go to build/demo or to FOLDER, which
# must exist. build/release/samples/aqorb_demo --help says how to read the tables.
#
# With --images it only fetches these samples and prints their folder, for the other samples and the notebook:
#
#   export OPENCV_SAMPLES_DATA_PATH=$(scripts/demo.sh --images)
#
# Elsewhere than on Debian, name the folder samples/data of OpenCV's source in this variable.
source "$(dirname "$0")/common.sh"

if [[ ${1:-} == --images ]]; then
    command -v apt-get >/dev/null ||
        die "this is not Debian. Take the folder samples/data of OpenCV's source, and name it in OPENCV_SAMPLES_DATA_PATH"
    opencv_samples >&2
    echo "$OPENCV_SAMPLES"
    exit
fi

images=()
for argument; do
    case $argument in
    --nfeatures=* | --out=*) ;;
    -*) die "there is no option $argument; --help lists those that there are" ;;
    *) images+=("$argument") ;;
    esac
done
((${#images[@]} == 0 || ${#images[@]} == 2)) || die "${#images[@]} images; two are accepted, or none for examples"

need build
mkdir -p "$BUILD/demo"
configure release -DAQORB_BUILD_SAMPLES=ON >"$BUILD/demo/configure.log" 2>&1 || die "see $BUILD/demo/configure.log"
build "$BUILD/release" --target aqorb_demo

if ((${#images[@]} == 0)); then
    opencv_samples
    export OPENCV_SAMPLES_DATA_PATH=$OPENCV_SAMPLES
    if strecha fountain-P11; then export AQORB_STRECHA; else echo "The demo goes on without the fountain."; fi
fi
export OPENCV_LOG_LEVEL=${OPENCV_LOG_LEVEL:-ERROR}  # else OpenCV warns of each of its pictures that it finds

say "AdaptiveQuadtreeORB beside cv::ORB"
exec "$BUILD/release/samples/aqorb_demo" --out="$BUILD/demo" "$@"
