#!/usr/bin/env bash
# Builds and installs the Python package as packagers do: from its source distribution, unpacked where there is no git,
# with the network cut off. It uses the OpenCV that is installed.
#
#   scripts/offline.sh [--source]
#
# With --source it compiles OpenCV from a folder of its source instead, which takes some minutes.
#
# Installs the Debian packages it needs; pip fetches the tools, before the network is cut off.
source "$(dirname "$0")/common.sh"

mode=${1:-}
[[ $mode =~ ^(|--source)$ ]] || die "unknown option $mode; --help says what there is"
need build wheel util-linux
isolate=(unshare --net)
((EUID == 0)) || isolate+=(--user --map-root-user)
"${isolate[@]}" true || die "the network cannot be cut off here"

settings=(--config-settings=cmake.define.AQORB_BUNDLE_OPENCV=OFF)
if [[ $mode ]]; then
    opencv_release 4
    settings=(--config-settings=cmake.define.AQORB_OPENCV_SOURCE="$OPENCV_SOURCE"
        --config-settings=cmake.define.AQORB_OPENCV_BUILD="$BUILD/offline/opencv")
fi
tools=$BUILD/venv/offline
environment "$tools" build numpy pybind11 scikit-build-core
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export CCACHE_BASEDIR=$folder

say "The source distribution"
(cd "$ROOT" && "${isolate[@]}" "$tools/bin/python" -m build --sdist --no-isolation --outdir "$folder" . \
    >"$folder/log" 2>&1) || { tail -n 30 "$folder/log" && die "it was not built"; }
tar -xz -C "$folder" -f "$folder"/aqorb-*.tar.gz --strip-components=1 --one-top-level=source

say "pip install, without a network"
(cd "$folder" && "${isolate[@]}" "$tools/bin/pip" install -v --no-build-isolation --no-deps "${settings[@]}" ./source \
    >"$folder/log" 2>&1) || { tail -n 30 "$folder/log" && die "it was not installed"; }
cd "$folder"
"$tools/bin/python" -m aqorb --version
"$tools/bin/python" "$ROOT/bindings/python/test/without_cv2.py"
