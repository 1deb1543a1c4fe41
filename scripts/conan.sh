#!/usr/bin/env bash
# Builds the Conan package of the library, static and shared, with the recipe in packaging/conan, and a program with each.
#
#   scripts/conan.sh
#
# Conan's cache is build/conan. Installs the Debian packages it needs; pip fetches Conan.
source "$(dirname "$0")/common.sh"

need build wheel
tools=$BUILD/venv/conan
environment "$tools" conan
export CONAN_HOME=$BUILD/conan/home CCACHE_BASEDIR=$BUILD/conan
rm -rf "$BUILD/conan"
"$tools/bin/conan" profile detect >/dev/null 2>&1
for shared in False True; do
    say "The package, shared=$shared"
    "$tools/bin/conan" create "$ROOT/packaging/conan" --no-remote --options "&:shared=$shared" \
        >"$BUILD/conan/$shared.log" 2>&1 || { tail -n 30 "$BUILD/conan/$shared.log" && die "see $BUILD/conan/$shared.log"; }
    grep -A 3 'Running test()' "$BUILD/conan/$shared.log"
done
