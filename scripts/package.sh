#!/usr/bin/env bash
# Builds the Debian packages libaqorb0.1, libaqorb-dev, aqorb-tools and python3-aqorb in build/packages.
#
#   scripts/package.sh [--test]
#
# With --test they are installed on a fresh system of the same release, in a folder of its own; programs of each
# kind are built and run there, and the packages removed again. That needs root.
source "$(dirname "$0")/common.sh"

need build-essential cmake libopencv-dev dpkg-dev file python3-dev pybind11-dev python3-numpy

folder=$BUILD/package
packages=$BUILD/packages
export DEB_BUILD_MAINT_OPTIONS=hardening=+all
CXXFLAGS="$(dpkg-buildflags --get CXXFLAGS) $(dpkg-buildflags --get CPPFLAGS)"
LDFLAGS=$(dpkg-buildflags --get LDFLAGS)
export CXXFLAGS LDFLAGS
configure "$folder" -DCMAKE_INSTALL_PREFIX=/usr -DAQORB_BUILD_TESTS=OFF -DAQORB_BUILD_SAMPLES=OFF \
    -DAQORB_BUILD_PYTHON=ON -DPython_EXECUTABLE="$PYTHON"
build "$folder"
rm -rf "$packages"
(cd "$folder" && cpack -B "$packages" >cpack.log) || die "see $folder/cpack.log"
rm -rf "$packages/_CPack_Packages"
for package in "$packages"/*.deb; do
    say "$(basename "$package")"
    dpkg-deb --field "$package" Depends
    dpkg-deb --contents "$package" | awk '$1 !~ /^d/ { print $6, $7, $8 }'
done
[[ ${1:-} == --test ]] || exit 0

need debootstrap
system=$BUILD/system
inside() { as_root chroot "$system" "$@"; }
say "A fresh system"
as_root rm -rf "$system"
# shellcheck disable=SC1091
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
as_root debootstrap --variant=minbase "$release" "$system" >"$BUILD/system.log" || die "see $BUILD/system.log"
as_root mkdir "$system/work"
as_root cp "$packages"/*.deb "$ROOT"/tools/consumer/* "$ROOT/bindings/python/test/test_installed.py" "$system/work"

say "Installing"
quietly=(env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends)
inside "${quietly[@]}" cmake g++ make pkg-config >"$BUILD/system.log" 2>&1 || die "see $BUILD/system.log"
inside sh -c "${quietly[*]} /work/*.deb" >>"$BUILD/system.log" 2>&1 || die "see $BUILD/system.log"

say "A project of CMake"
inside sh -ec 'cmake -S /work -B /work/build >/dev/null && cmake --build /work/build >/dev/null && /work/build/consumer'
say "A program by pkg-config"
inside sh -ec 'cd /work && g++ -std=c++11 main.cpp -o consumer $(pkg-config --cflags --libs aqorb) && ./consumer'
say "Python"
inside python3 /work/test_installed.py
say "Python, cv2 unchanged"
inside sh -ec 'LD_PRELOAD=libaqorb_preload.so python3 -c "import cv2; print(cv2.ORB_create().getDefaultName())"' |
    tee "$BUILD/preload.txt"
grep -q AdaptiveQuadtreeORB "$BUILD/preload.txt"

say "Removing"
inside apt-get purge -y -qq 'libaqorb*' aqorb-tools python3-aqorb >>"$BUILD/system.log" 2>&1
left=$(inside find /usr /etc /var/lib -iname '*aqorb*' -not -path '/var/lib/dpkg/*' -not -name '*.pyc')
[[ -z $left ]] || die "left behind: $left"
say "The packages install, serve and go"
