#!/usr/bin/env bash
# Builds the Debian packages libaqorb0.5, libaqorb-dev, aqorb-tools, aqorb-preload and python3-aqorb in
# build/packages, and has lintian check them.
#
#   scripts/package.sh [--test] [CMake option...]
#
# With --test they are installed on a fresh system of the same release, in a folder of its own. Programs of each
# kind are built and run there. Then the packages are removed, and so is the folder. This needs root.
# -DAQORB_PACKAGE_CONTACT='NAME <ADDRESS>' names the maintainer. Use it if you give the packages to others.
# Installs the Debian packages it needs.
source "$(dirname "$0")/common.sh"

test=
if [[ ${1:-} == --test ]]; then test=yes && shift; fi
need build package

folder=$BUILD/package
packages=$BUILD/packages
export DEB_BUILD_MAINT_OPTIONS=hardening=+all
CXXFLAGS="$(dpkg-buildflags --get CXXFLAGS) $(dpkg-buildflags --get CPPFLAGS)"
LDFLAGS=$(dpkg-buildflags --get LDFLAGS)
export CXXFLAGS LDFLAGS
# The date of the packages' changelog.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(stat -c %Y "$ROOT/CHANGELOG.md")}
export SOURCE_DATE_EPOCH
say "The packages: some minutes the first time"
configure package -DPython_EXECUTABLE="$PYTHON" "$@"
(cd "$ROOT" && cmake --build --preset package --parallel "$JOBS")
rm -rf "$packages"
(cd "$folder" && cpack -B "$packages" >cpack.log) || die "see $folder/cpack.log"
rm -rf "$packages/_CPack_Packages"
for package in "$packages"/*.deb; do
    say "$(basename "$package")"
    dpkg-deb --field "$package" Depends
    dpkg-deb --contents "$package" | awk '$1 !~ /^d/ { print $6, $7, $8 }'
done

say "lintian"
# The suppressed tags ask that an upload to Debian closes a report, which these packages are not, and that libraries leave
# ldconfig to a trigger, where CPack calls it as well.
lintian --allow-root --fail-on error,warning \
    --suppress-tags initial-upload-closes-no-bugs,maintscript-calls-ldconfig "$packages"/*.deb
echo "no errors, no warnings"
[[ $test ]] || exit 0

need debootstrap
system=$BUILD/system
inside() { as_root chroot "$system" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 "$@"; }
say "A fresh system"
as_root rm -rf "$system"
trap 'as_root rm -rf "$system"' EXIT
log=$BUILD/system.log
as_root debootstrap --variant=minbase "$(codename)" "$system" "$(mirror)" >"$log" || die "see $log"
as_root mkdir "$system/packages"
as_root cp "$packages"/*.deb "$ROOT"/tools/consumer/{CMakeLists.txt,main.cpp} \
    "$ROOT/bindings/python/test/without_cv2.py" "$system/packages"

say "Installing"
quietly=(env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends)
inside "${quietly[@]}" cmake g++ make pkg-config python3-pil >>"$log" 2>&1 || die "see $log"
inside sh -c "${quietly[*]} /packages/*.deb" >>"$log" 2>&1 || die "see $log"
say "A project of CMake"
inside sh -ec 'cmake -S /packages -B /packages/build >/dev/null && cmake --build /packages/build >/dev/null && /packages/build/consumer'
say "A program by pkg-config"
inside sh -ec 'cd /packages && g++ -std=c++11 main.cpp -o consumer $(pkg-config --cflags --libs aqorb) && ./consumer'
say "Python"
inside python3 /packages/without_cv2.py
say "Programs"
inside sh -ec 'cd /packages && aqorb_demo --help >/dev/null && aqorb_demo noise.png'
inside python3 -m aqorb draw /packages/noise.png /packages/noise.png --out /packages/matches.png
say "Python, cv2 unchanged"
inside sh -ec 'LD_PRELOAD=libaqorb_preload.so python3 -c "import cv2; print(cv2.ORB_create().getDefaultName())"' |
    tee "$BUILD/preload.txt"
grep -q AdaptiveQuadtreeORB "$BUILD/preload.txt"

say "Removing"
inside apt-get purge -y -qq 'libaqorb*' 'aqorb-*' python3-aqorb >>"$log" 2>&1 || die "see $log"
left=$(inside find /usr /etc /var -iname '*aqorb*' -not -path '/var/cache/apt/*')
[[ -z $left ]] || die "left behind: $left"
say "The packages were installed, used and removed"
