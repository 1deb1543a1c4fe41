#!/usr/bin/env bash
# Builds the page that compares both detectors in a browser: build/web/page, which any web server can offer as it is.
#
#   scripts/web.sh [--serve [PORT] | --test]
#
# The module and the parts of OpenCV that it needs are compiled to WebAssembly with SIMD, for one thread.
#
# With --serve the page is offered on this machine, at http://localhost:8000 or another PORT, until Ctrl-C.
# With --test the results are compared with those of the native library, in Node.js and in headless Chromium, and the
# page is used there as people would. The screenshots are in build/web/screenshots. If OPENCV_TEST_DATA_PATH names
# opencv_extra's testdata folder, six photographs are compared, too.
#
# Installs the Debian packages it needs, and says how much that is. pip fetches OpenCV's source, and npm what drives
# Chromium. The first time takes some 8 minutes and 1.9 GB on disk.
source "$(dirname "$0")/common.sh"

WEB=$BUILD/web
TOOLCHAIN=/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake
# Debian's emscripten asks its modules of Node.js by name; a Node.js that is not Debian's would not look there.
export NODE_PATH=/usr/share/nodejs

mode=${1:-}
[[ $mode =~ ^(|--serve|--test)$ ]] || die "unknown option $mode; --help says what there is"
port=${2:-8000}
if [[ $mode == --serve ]]; then  # before minutes are spent on the page
    if ! [[ $port =~ ^[0-9]{1,5}$ ]] || ((port < 1 || port > 65535)); then
        die "PORT is $port; 1 to 65535 is accepted"
    fi
    if (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; then
        die "port $port is in use; name another one: scripts/web.sh --serve $((port < 65535 ? port + 1 : 8000))"
    fi
fi

compile() {
    forget_moved "$WEB" "$ROOT"
    cmake -S "$ROOT" -B "$WEB" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$TOOLCHAIN" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_CXX_FLAGS="-fwasm-exceptions -msimd128" -DBUILD_SHARED_LIBS=OFF -DAQORB_WERROR=ON \
        -DAQORB_BUNDLE_OPENCV=ON -DAQORB_OPENCV_SOURCE="$OPENCV_SOURCE" -DAQORB_OPENCV_BUILD="$WEB/opencv" \
        -DAQORB_BUILD_TESTS=OFF -DAQORB_BUILD_SAMPLES=OFF -DAQORB_BUILD_PRELOAD=OFF -DAQORB_INSTALL=OFF
    build "$WEB"
}

# sizes: of what a browser fetches, as files and as most servers send them.
sizes() {
    local file
    printf '%-24s %9s %9s\n' file bytes gzip
    for file in "$WEB"/page/*.* "$WEB"/page/photographs/*; do
        printf '%-24s %9d %9d\n' "${file#"$WEB/page/"}" "$(stat -c %s "$file")" "$(gzip -9 -c "$file" | wc -c)"
    done
}

# native FILE [ARGUMENT...]: what the native aqorb_fingerprint prints.
native() {
    "$BUILD/release/tools/fingerprint/aqorb_fingerprint" "${@:2}" >"$WEB/native/$1" 2>"$WEB/native/log" ||
        die "aqorb_fingerprint failed; see $WEB/native/log"
}

tests() {
    local image images=("$ROOT/doc/images/reproduction-figure8.png")
    need build
    command -v chromium >/dev/null || need chromium
    command -v npm >/dev/null || need npm

    say "The native library's fingerprints"
    configure release -DAQORB_BUILD_FINGERPRINT=ON >"$WEB/native.log"
    build "$BUILD/release" --target aqorb_fingerprint >>"$WEB/native.log" || die "see $WEB/native.log"
    mkdir -p "$WEB/native"
    native ranked.txt "${images[0]}"
    native quadtree.txt --quadtree "${images[0]}"
    if [[ -d ${OPENCV_TEST_DATA_PATH:-} ]]; then
        for image in "$OPENCV_TEST_DATA_PATH"/cv/detectors_descriptors_evaluation/images_datasets/*/img1.png; do
            images+=("$image")
            native "${image//\//_}.txt" "$image"
        done
    fi

    say "In Node.js"
    node "$ROOT/web/test/engine.mjs" "$WEB/page" "$WEB/native"

    say "In Chromium"
    local lock=$ROOT/web/test/package-lock.json
    if ! cmp -s "$lock" "$WEB/test/installed"; then
        mkdir -p "$WEB/test"
        cp "$ROOT/web/test/package.json" "$lock" "$WEB/test/"
        (cd "$WEB/test" && npm ci --ignore-scripts --no-audit --no-fund >npm.log 2>&1) ||
            die "npm failed; see $WEB/test/npm.log; is there a network?"
        cp "$lock" "$WEB/test/installed"
    fi
    rm -rf "$WEB/screenshots"
    PLAYWRIGHT=$WEB/test node "$ROOT/web/test/page.mjs" "$WEB/page" "$WEB/native" "$WEB/screenshots" "${images[@]}"
}

[[ -e $WEB/page/aqorb.wasm ]] || say "The first time: some 8 minutes with two processors, 1.9 GB on disk"
need web
opencv_release 4
say "The page: CMake asks the compiler first, without a word for up to a minute"
compile
sizes
say "$WEB/page/index.html"

case $mode in
--serve)
    echo "http://localhost:$port"
    "$PYTHON" -m http.server --bind 127.0.0.1 --directory "$WEB/page" "$port"
    ;;
--test)
    tests
    ;;
esac
