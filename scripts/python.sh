#!/usr/bin/env bash
# Builds the Python package, runs its tests, those of the Python samples, and the demo.
#
#   scripts/python.sh [pytest option ...]
#   scripts/python.sh --asan [pytest option ...]
#
# With --asan it runs only the package's tests, on an extension module with additional checks. AddressSanitizer ends the
# process at a wrong access to memory. pybind11 ends it if a reference is taken or released without the GIL.
#
# Installs the Debian packages it needs; pip fetches those of the command aqorb. It leaves the package in
# build/release/bindings/python, where programs find it with PYTHONPATH. Tests that need images of opencv_extra are skipped
# unless OPENCV_TEST_DATA_PATH names its testdata folder.
source "$(dirname "$0")/common.sh"

asan=
if [[ ${1:-} == --asan ]]; then
    asan=1
    shift
fi

need build test python

if [[ $asan ]]; then
    folder=$BUILD/asan-python
    configure asan-python -DPython_EXECUTABLE="$PYTHON"
    build "$folder" --target _aqorb

    say "Tests with AddressSanitizer"
    # Python itself is not instrumented: the sanitizer must be loaded first, with the library whose exceptions it
    # intercepts, and see every object as a block of its own. What Python keeps until it exits is not a leak. mypy does
    # not load the module.
    libraries=$(c++ -print-file-name=libasan.so):$(c++ -print-file-name=libstdc++.so.6)
    LD_PRELOAD=$libraries ASAN_OPTIONS=detect_leaks=0 PYTHONMALLOC=malloc PYTHONPATH=$folder/bindings/python \
        PYTHONDONTWRITEBYTECODE=1 AQORB_BINDING=aqorb "$PYTHON" -X faulthandler -m pytest -q -p no:cacheprovider \
        --capture=sys `# else the report of the sanitizer is lost` \
        --deselect "$ROOT/bindings/python/test/test_package.py::test_stub_is_a_stub_of_the_package" \
        --deselect "$ROOT/bindings/python/test/test_package.py::test_programs_are_typed" "$@" \
        "$ROOT/modules/aqorb/misc/python/test" "$ROOT/bindings/python/test"
    exit
fi

configure release -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON"
build "$BUILD/release" --target _aqorb sample_images
export PYTHONPATH=$BUILD/release/bindings/python PYTHONDONTWRITEBYTECODE=1
export AQORB_SAMPLE_IMAGES=$BUILD/release/samples/test/sample_images

command_environment command
say "Tests"
AQORB_BINDING=aqorb "$PYTHON" -m pytest -q -p no:cacheprovider "$@" \
    "$ROOT/modules/aqorb/misc/python/test" "$ROOT/bindings/python/test" "$ROOT/samples/test"

say "The installed package"
prefix=$BUILD/prefix-python
rm -rf "$prefix"
for component in runtime python; do
    cmake --install "$BUILD/release" --component "$component" --prefix "$prefix" >/dev/null
done
PYTHONPATH=$(echo "$prefix"/lib/python3*/*-packages) "$PYTHON" -c 'import aqorb; print(aqorb.__file__)'

say "Demo"
opencv_samples
mkdir -p "$BUILD/demo-python"
OPENCV_SAMPLES_DATA_PATH=$OPENCV_SAMPLES "$PYTHON" "$ROOT/samples/aqorb_demo.py" --out="$BUILD/demo-python"
