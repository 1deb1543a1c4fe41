#!/usr/bin/env bash
# Makes the files of a release that can be made on Debian, in build/release-files, with their checksums, and publishes
# nothing: the source distribution and the wheels, the Debian packages, and the site with the page for browsers. It
# fails if a check of these files, or of the workflows that make those of all systems, finds anything.
#
#   scripts/release.sh
#
# This takes half an hour and needs root, for the wheels are built on a Debian 11 in a folder of its own. scripts/wheel.sh
# --test and scripts/package.sh --test make these files again and test them.
#
# Installs the Debian packages it needs; go, npm and pip fetch the rest.
source "$(dirname "$0")/common.sh"
(($# == 0)) || die "unknown option $1; --help says what there is"

version=$("$ROOT/scripts/version.sh")
files=$BUILD/release-files
rm -rf "$files"
"$ROOT/scripts/workflows.sh"
"$ROOT/scripts/wheel.sh"
"$ROOT/scripts/package.sh"
"$ROOT/scripts/web.sh"
"$ROOT/scripts/doc.sh"

say "The files of version $version"
mkdir -p "$files"
cp "$BUILD"/wheels/aqorb-"$version"{.tar.gz,-*.whl} "$BUILD"/packages/*.deb "$files"
tar -czf "$files/site.tar.gz" -C "$BUILD/doc/html" .
"$ROOT/scripts/version.sh" --notes >"$files/notes.md"
cd "$files"
sha256sum -- * >SHA256SUMS
wc -c -- *
