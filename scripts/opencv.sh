#!/usr/bin/env bash
# Builds the module inside OpenCV's own build, from Debian's source package, and runs what that build
# gives: accuracy tests, a smoke run of the performance tests, the Python test and, where ant and a JDK
# are installed, the Java wrappers' compilation.
#
#   scripts/opencv.sh
#
# Installs the Debian packages it needs. OPENCV_TEST_DATA_PATH is passed on to the tests.
source "$(dirname "$0")/common.sh"

need build-essential cmake ninja-build ccache zlib1g-dev libpng-dev libjpeg-dev python3-dev python3-numpy
opencv_source

# FindJNI does not know where Debian keeps its JDKs.
if [[ -z ${JAVA_HOME:-} ]] && command -v javac >/dev/null; then
    JAVA_HOME=$(dirname "$(dirname "$(readlink -f "$(command -v javac)")")")
    export JAVA_HOME
fi

modules=aqorb,calib3d,flann,stitching,imgcodecs,ts,highgui,videoio,python3,java,java_bindings_generator
modules+=,img_hash  # one of opencv_contrib's

# Nothing that the module and its tests can do without, and nothing that OpenCV would download.
options=(
    -DCMAKE_BUILD_TYPE=Release -DENABLE_CCACHE=OFF
    -DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache
    -DPYTHON3_EXECUTABLE="$PYTHON" -DPYTHON_DEFAULT_EXECUTABLE="$PYTHON"
    '-DCPU_DISPATCH=SSE4_1;AVX2;AVX512_SKX'
    -DOPENCV_DOWNLOAD_TRIES_LIST= -DBUILD_opencv_apps=OFF
    -DBUILD_ZLIB=OFF -DBUILD_PNG=OFF -DBUILD_JPEG=OFF
    -DBUILD_TESTS=ON -DBUILD_PERF_TESTS=ON -DBUILD_EXAMPLES=ON
    -DBUILD_LIST="$modules"
)
for feature in 1394 ADE EIGEN FFMPEG GSTREAMER GTK IPP ITT JASPER LAPACK OPENCL OPENEXR OPENJPEG PROTOBUF \
    QUIRC TIFF V4L VA VA_INTEL VTK WEBP; do
    options+=("-DWITH_$feature=OFF")
done

# configure_opencv FOLDER MODULES-PATH
configure_opencv() {
    say "OpenCV with OPENCV_EXTRA_MODULES_PATH=$2"
    rm -f "$1/CMakeCache.txt"
    cmake -S "$OPENCV_SOURCE" -B "$1" -G Ninja "${options[@]}" \
        -DOPENCV_EXTRA_MODULES_PATH="$2" >"$1.log" 2>&1 || {
        tail -n 50 "$1.log"
        die "OpenCV's configuration failed"
    }
    # OpenCV drops a module that it cannot build without an error.
    grep -q 'To be built:.* aqorb' "$1.log" || die "OpenCV does not build aqorb; see $1.log"
}

opencv=$BUILD/opencv-modules
mkdir -p "$BUILD"
configure_opencv "$opencv" "$ROOT/modules"
targets=(opencv_test_aqorb opencv_perf_aqorb opencv_python3 gen_opencv_java_source example_aqorb_demo)
if grep -q 'Java wrappers: *YES' "$opencv.log"; then targets+=(opencv_java); fi
build "$opencv" --target "${targets[@]}" 2>&1 | tee "$opencv.build.log"
if grep 'aqorb.*warning:' "$opencv.build.log"; then die "warnings in the build inside OpenCV"; fi

say "Accuracy tests"
(cd "$opencv" && bin/opencv_test_aqorb)

say "Performance tests, one sample each"
(cd "$opencv" && bin/opencv_perf_aqorb --perf_min_samples=1 --perf_force_samples=1)

say "Python test"
AQORB_BINDING=cv2 PYTHONPATH=$opencv/lib/python3:$OPENCV_SOURCE/modules/python/test \
    "$PYTHON" "$ROOT/modules/aqorb/misc/python/test/test_aqorb.py" -v

say "Java wrapper"
grep -r 'class AdaptiveQuadtreeORB extends ORB' "$opencv"/modules/java_bindings_generator/gen/java

# The other ways to name the module: the repository itself, and a list with opencv_contrib's modules. In
# folders of their own, so that nothing built above passes for theirs; in the same configuration, so that
# ccache has most of the objects.
configure_opencv "$BUILD/opencv-root" "$ROOT"
build "$BUILD/opencv-root" --target opencv_aqorb
configure_opencv "$BUILD/opencv-contrib" "$ROOT/modules;$OPENCV_SOURCE/contrib/modules"
build "$BUILD/opencv-contrib" --target opencv_aqorb opencv_img_hash

say "Built inside OpenCV from all three module paths"
