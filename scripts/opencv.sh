#!/usr/bin/env bash
# Builds the module inside OpenCV and opencv_contrib, from Debian's source package, by nothing but OpenCV's own
# build. The module is what scripts/contrib.sh would send to opencv_contrib. Runs what that build gives: the accuracy
# tests, a smoke run of the performance tests, the Python test, and the generators of the other wrappers. Then shows that
# OpenCV's build finds the module in this repository as well.
#
#   scripts/opencv.sh [--java]
#   scripts/opencv.sh --release 4|5
#
# --java compiles the Java wrapper, too, and runs its tests. With --release the source is that of the newest OpenCV 4, or
# of OpenCV 5, from the Python package index, without opencv_contrib. The script then ends after the Python test, and
# leaves OpenCV without the module in build/opencv-4 or build/opencv-5, for scripts/compatibility.sh.
#
# Installs the Debian packages it needs. OPENCV_TEST_DATA_PATH is passed on to the tests.
source "$(dirname "$0")/common.sh"

release='' java=''
case ${1:-} in
'') ;;
--java) java=yes ;;
--release)
    release=${2:-}
    [[ $release =~ ^[45]$ ]] || die "--release needs 4 or 5"
    ;;
*) die "unknown option $1; --help says what there is" ;;
esac

need build test opencv ${java:+java}
if [[ $release ]]; then opencv_release "$release"; else opencv_source; fi

# FindJNI does not know where Debian keeps its JDKs.
if [[ $java && -z ${JAVA_HOME:-} ]]; then
    JAVA_HOME=$(dirname "$(dirname "$(readlink -f "$(command -v javac)")")")
    export JAVA_HOME
fi

name=${release:+-$release}
opencv=$BUILD/opencv$name
contrib=$BUILD/opencv_contrib$name
module=$contrib/modules/aqorb

# Nothing that the module and its tests can do without, and nothing that OpenCV would download.
modules=aqorb,calib3d,flann,stitching,imgcodecs,ts,highgui,videoio,python3
# The first OpenCV that reads misc/js/gen_dict.json is newer than Debian's.
if [[ $release ]]; then
    modules+=,js_bindings_generator
else
    modules+=,java_bindings_generator,objc_bindings_generator
fi
[[ ! $java ]] || modules+=,java
[[ $release != 5 ]] || modules=${modules/calib3d/geometry}
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

# configure_opencv MODULES-PATH
configure_opencv() {
    say "OpenCV with OPENCV_EXTRA_MODULES_PATH=$1"
    cmake -S "$OPENCV_SOURCE" -B "$opencv" -G Ninja "${options[@]}" \
        -DOPENCV_EXTRA_MODULES_PATH="$1" 2>&1 | tee "$opencv.log"
}

# check_configuration FOLDER: that OpenCV builds the module from there, with its tests and all samples.
check_configuration() {
    # OpenCV drops a module that it cannot build without an error.
    grep -q 'To be built:.* aqorb' "$opencv.log" || die "OpenCV does not build aqorb; see $opencv.log"
    grep -qxF "OPENCV_MODULE_opencv_aqorb_LOCATION:INTERNAL=$1" "$opencv/CMakeCache.txt" ||
        die "OpenCV does not take aqorb from $1"
    local sample programs=(opencv_test_aqorb opencv_perf_aqorb)
    for sample in "$ROOT"/samples/*.cpp; do programs+=("example_aqorb_$(basename "$sample" .cpp)"); done
    ninja -C "$opencv" -t query "${programs[@]}" >/dev/null || die "a program is not built inside OpenCV"
}

mkdir -p "$BUILD"
if [[ $release ]]; then
    say "The module as in opencv_contrib"
    rm -rf "$contrib"
    mkdir -p "$contrib/modules"
    "$ROOT/scripts/contrib.sh" --copy "$contrib/modules"
else
    "$ROOT/scripts/contrib.sh"
fi

rm -f "$opencv/CMakeCache.txt"
configure_opencv "$contrib/modules" || die "OpenCV's configuration failed; see $opencv.log"
check_configuration "$module"
targets=(opencv_test_aqorb opencv_perf_aqorb opencv_samples_aqorb opencv_python3)
if [[ $release ]]; then
    targets+=(gen_opencv_js_source)
else
    targets+=(gen_opencv_java_source gen_opencv_objc_source)
fi
[[ ! $java ]] || targets+=(opencv_java opencv_test_java)
build "$opencv" --target "${targets[@]}" 2>&1 | tee "$opencv.build.log"
if grep 'aqorb.*warning:' "$opencv.build.log"; then die "warnings in the build inside OpenCV"; fi

say "Accuracy tests"
(cd "$opencv" && bin/opencv_test_aqorb)

say "Performance tests, one sample each"
(cd "$opencv" && bin/opencv_perf_aqorb --perf_min_samples=1 --perf_force_samples=1)

say "Samples"
"$opencv/bin/example_aqorb_aqorb_demo" --help
ls "$opencv"/bin/example_aqorb_*

say "Python test"
PYTHONPATH=$opencv/lib/python3:$OPENCV_SOURCE/modules/python/test \
    "$PYTHON" "$module/misc/python/test/test_aqorb.py" -v

# generated FILE TEXT...: that OpenCV's generators have made these.
generated() {
    local text
    for text in "${@:2}"; do
        grep -rqF -- "$text" "$opencv/modules/$1" || die "OpenCV's generator has not made: $text"
        echo "$text"
    done
}

say "Other wrappers"
if [[ $release ]]; then
    generated js_bindings_generator/gen/bindings.cpp 'function("aqorb_retainUniform"' \
        '("aqorb_AdaptiveQuadtreeORB")' '("aqorb_HammingMatcher")'
else
    generated java_bindings_generator/gen/java 'class AdaptiveQuadtreeORB extends ORB' \
        'class HammingMatcher extends BFMatcher' 'void retainUniform('
    generated objc_bindings_generator '@interface AdaptiveQuadtreeORB : ORB' \
        '@interface HammingMatcher : BFMatcher' '+ (HammingMatcher*)createHammingMatcher:(NormTypes)normType' \
        '+ (void)retainUniform:'
fi

if [[ $java ]]; then
    say "Java tests"
    # OpenCV's test case warns of a picture that Debian's source does not have.
    for test in "$module"/misc/java/test/*.java; do
        OPENCV_LOG_LEVEL=ERROR "$JAVA_HOME/bin/java" -Djava.library.path="$opencv/lib" \
            -cp "$opencv/java_test/build/classes:$(printf '%s:' "$opencv"/bin/*.jar "$opencv"/java_test/lib/*.jar)" \
            junit.textui.TestRunner "org.opencv.test.aqorb.$(basename "$test" .java)"
    done
fi

# OpenCV itself has been built. What was built of the copy is removed, so that it cannot be taken for the module of this
# repository.
rm -rf "$opencv"/modules/aqorb "$opencv"/lib/libopencv_aqorb*
if [[ $release ]]; then
    configure_opencv "" || die "OpenCV's configuration failed; see $opencv.log"
    say "Built inside OpenCV $(sed -n 's/^set(OpenCV_VERSION \([0-9.]*\).*/\1/ip' "$opencv/OpenCVConfig.cmake" | head -n 1)"
    exit
fi

# These are only configured: but for the licence's header, the files are those that have been built.
say "The module from this repository"
for folder in "$ROOT/modules" "$ROOT"; do
    configure_opencv "$folder" || die "OpenCV's configuration failed; see $opencv.log"
    check_configuration "$ROOT/modules/aqorb"
    echo "OpenCV finds the module."
done
say "Built inside opencv_contrib, and found in this repository"
