#!/usr/bin/env bash
# Tests collections of images in their long form, or measures the rates at which features are extracted.
#
#   scripts/collection.sh [--rates [option of tools/collection/rates.py ...]]
#
# The tests have 500 photographs go through the command aqorb, the function and the sample on Ray, kill a worker of Ray,
# and send 10,000 small images through the command. With --rates it prints the tables of the tutorial "Many images".
#
# The photographs are those of opencv_extra, whose folder testdata OPENCV_TEST_DATA_PATH names. Installs the Debian
# packages it needs; pip fetches those of the command and Ray, 250 MB, which is why .ci/run does not run this.
source "$(dirname "$0")/common.sh"

photographs=${OPENCV_TEST_DATA_PATH:-}/cv/detectors_descriptors_evaluation/images_datasets
[[ -d $photographs ]] || die "OPENCV_TEST_DATA_PATH must name the folder testdata of opencv_extra"
need build python
configure release -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON"
build "$BUILD/release" --target _aqorb
export PYTHONPATH=$BUILD/release/bindings/python PYTHONDONTWRITEBYTECODE=1 AQORB_PHOTOGRAPHS=$photographs

if [[ ${1:-} == --rates ]]; then
    command_environment command
    say "Rates"
    exec "$PYTHON" "$ROOT/tools/collection/rates.py" --out="$BUILD/rates" "${@:2}" "$photographs"
fi
command_environment ray 'ray[data]==2.60.0' 'pandas<2.3' 'numpy<2'
say "Tests"
"$PYTHON" -m pytest -q -s -p no:cacheprovider "$@" "$ROOT/samples/collection"
