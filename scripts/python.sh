#!/usr/bin/env bash
# Builds the Python package, and runs its tests and those of the Python samples.
#
#   scripts/python.sh [pytest option ...]
#   scripts/python.sh --asan [pytest option ...]
#   scripts/python.sh --offline
#   scripts/python.sh --notebook
#   scripts/python.sh --collection [pytest option ...]
#   scripts/python.sh --hostile [--flips=1000] [--kills=50]
#
# The package is left in build/release/python, where programs find it with PYTHONPATH. Tests that need images of
# opencv_extra are skipped unless OPENCV_TEST_DATA_PATH names its testdata folder.
#
# With --asan the package's tests run on an extension module with additional checks. AddressSanitizer ends the process at
# a wrong access to memory. pybind11 ends it if a reference is taken or released without the GIL.
#
# With --offline the package is installed as packagers do it: from its source distribution, unpacked where there is no
# git, against the installed OpenCV, with the network cut off.
#
# With --notebook it installs the package by pip beside a cv2 of pip, runs the notebook of the samples there, and leaves it
# with its pictures in build/notebook/aqorb.ipynb, from where it is copied to the samples when it changes.
#
# With --collection it tests collections of images in their long form. 500 photographs of opencv_extra go through the
# command aqorb, the function and the sample on Ray, a worker of Ray is killed, and 10,000 small images go through the
# command. pip fetches Ray, 250 MB.
#
# With --hostile the command aqorb is given damaged files and is killed while it writes, and a table says what came of it.
#
# Installs the Debian packages it needs; pip fetches those of the command aqorb, and the tools.
source "$(dirname "$0")/common.sh"

tests=("$ROOT/modules/aqorb/misc/python/test" "$ROOT/python/test")
pytest=(env PYTHONDONTWRITEBYTECODE=1)

asan() {
    local libraries
    need build test python
    configure asan-python -DPython_EXECUTABLE="$PYTHON"
    build "$BUILD/asan-python" --target _aqorb
    say "Tests with AddressSanitizer"
    # Python itself is not instrumented: the sanitizer must be loaded first, with the library whose exceptions it
    # intercepts, and see every object as a block of its own. What Python keeps until it exits is not a leak, and
    # memory that is refused is a MemoryError. mypy does not load the module.
    libraries=$(c++ -print-file-name=libasan.so):$(c++ -print-file-name=libstdc++.so.6)
    "${pytest[@]}" LD_PRELOAD="$libraries" ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 PYTHONMALLOC=malloc \
        PYTHONPATH="$BUILD/asan-python/python" "$PYTHON" -X faulthandler -m pytest -q -p no:cacheprovider \
        --capture=sys `# else the report of the sanitizer is lost` \
        --deselect python/test/test_package.py::test_stub_is_a_stub_of_the_package "$@" "${tests[@]}"
}

offline() {
    local isolate=(unshare --net) tools=$BUILD/venv/offline folder
    need build wheel
    ((EUID == 0)) || isolate+=(--user --map-root-user)
    "${isolate[@]}" true || die "the network cannot be cut off here"
    environment "$tools" build numpy pybind11 scikit-build-core
    folder=$(mktemp -d)
    export CCACHE_BASEDIR=$folder
    say "The source distribution"
    (cd "$ROOT" && "${isolate[@]}" "$tools/bin/python" -m build --sdist --no-isolation --outdir "$folder" . \
        >"$folder/log" 2>&1) || { tail -n 30 "$folder/log" && die "it was not built"; }
    tar -xz -C "$folder" -f "$folder"/aqorb-*.tar.gz --strip-components=1 --one-top-level=source
    say "pip install, without a network"
    (cd "$folder" && "${isolate[@]}" "$tools/bin/pip" install -v --no-build-isolation --no-deps \
        -C cmake.define.AQORB_BUNDLE_OPENCV=OFF ./source >"$folder/log" 2>&1) ||
        { tail -n 30 "$folder/log" && die "it was not installed"; }
    cd "$folder"
    "$tools/bin/python" -m aqorb --version
    "$tools/bin/python" "$ROOT/python/test/without_cv2.py"
    rm -rf "$folder"
}

package() {
    need build test python
    configure release -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON"
    build "$BUILD/release" --target _aqorb sample_images
    export PYTHONPATH=$BUILD/release/python:$ROOT/photographs
}

notebook() {
    need build wheel
    opencv_samples
    say "The notebook, beside opencv-python-headless $OPENCV_4: some 3 minutes, most of them without a word"
    environment "$BUILD/venv/notebook" ipykernel matplotlib nbconvert "opencv-python-headless==$OPENCV_4" "$ROOT" "$ROOT/photographs"
    "$BUILD/venv/notebook/bin/python" -m aqorb --version
    PATH=$BUILD/venv/notebook/bin:$PATH OPENCV_SAMPLES_DATA_PATH=$OPENCV_SAMPLES \
        jupyter nbconvert --execute --to notebook --log-level=WARN \
        --output-dir "$BUILD/notebook" "$ROOT/samples/notebook/aqorb.ipynb"
    ls -l "$BUILD/notebook/aqorb.ipynb"
}

collection() {
    export AQORB_PHOTOGRAPHS=${OPENCV_TEST_DATA_PATH:-}/cv/detectors_descriptors_evaluation/images_datasets
    [[ -d $AQORB_PHOTOGRAPHS ]] || die "OPENCV_TEST_DATA_PATH must name the folder testdata of opencv_extra"
    package
    command_environment ray 'ray[data]==2.60.0' 'pandas<2.3' 'numpy<2' psutil
    say "Tests of collections"
    "${pytest[@]}" "$PYTHON" -m pytest -q -s -p no:cacheprovider "$@" "$ROOT/photographs/samples"
}

hostile() {
    package
    command_environment command
    say "Damaged files, and kills"
    "$PYTHON" "$ROOT/photographs/test/hostile.py" "$@"
}

case ${1:-} in
--asan | --offline | --notebook | --collection | --hostile)
    "${1#--}" "${@:2}"
    exit
    ;;
esac

package
command_environment command
say "Tests"
"${pytest[@]}" AQORB_SAMPLE_IMAGES="$BUILD/release/samples/test/sample_images" "$PYTHON" -m pytest -q \
    -p no:cacheprovider "$@" "${tests[@]}" "$ROOT/samples/test"
"${pytest[@]}" "$PYTHON" -m pytest -q -p no:cacheprovider "$@" "$ROOT/photographs/test"

say "The installed package"
prefix=$BUILD/prefix-python
rm -rf "$prefix"
for component in runtime python; do
    cmake --install "$BUILD/release" --component "$component" --prefix "$prefix" >/dev/null
done
PYTHONPATH=$(echo "$prefix"/lib/python3*/*-packages) "$PYTHON" -c 'import aqorb; print(aqorb.__file__)'
