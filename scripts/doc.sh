#!/usr/bin/env bash
# Builds the documentation as a web site, build/doc/html/index.html, with doxygen and the theme doxygen-awesome-css. A
# warning of doxygen is an error, and so is a link in a document that leads nowhere, or a directive that other viewers of
# Markdown would show.
#
#   scripts/doc.sh [--opencv]
#
# With --opencv it builds OpenCV's own documentation instead, of this module and of those that it depends on:
# build/opencv-doc/doc/doxygen/html/index.html. This fetches OpenCV's source.
#
# Installs the Debian packages it needs.
source "$(dirname "$0")/common.sh"

need doc
# BibTeX finds its files here without TeX's configuration, which is a large package.
export BIBINPUTS=. BSTINPUTS=.

if [[ ${1:-} == --opencv ]]; then
    need build zlib1g-dev
    opencv_source
    folder=$BUILD/opencv-doc
    configure_opencv opencv-doc "$ROOT/modules" -DBUILD_LIST=aqorb -DBUILD_DOCS=ON -DWITH_JPEG=OFF -DWITH_PNG=OFF
    cmake --build "$folder" --target doxygen_cpp >"$folder/doc.log" 2>&1 || die "see $folder/doc.log"
    if grep 'aqorb.*warning:' "$folder/doc.log"; then die "warnings"; fi
    html=$folder/doc/doxygen/html
    [[ -n $(find "$html" -name tutorial_aqorb_slam.html) ]] || die "OpenCV's documentation lacks the tutorials"
    say "$html/index.html"
    exit
fi

export THEME=/usr/share/doxygen-awesome-css VERSION
VERSION=$("$ROOT/scripts/release.sh" --version)
site=$ROOT/doc/site OUT=$BUILD/doc
cd "$ROOT"
find . -name 'build*' -prune -o -path ./.git -prune -o \( -name '*.md' -o -name '*.markdown' \) -print0 |
    sort -z | xargs -0 "$PYTHON" -B "$site/check.py"

rm -rf "$OUT"
mkdir -p "$OUT"
cp "$site/Doxyfile" "$site/layout.xml" "$OUT/"
# Newer versions of doxygen have colours of their own, which the theme does not expect.
if [[ $(doxygen -g -) == *HTML_COLORSTYLE\ * ]]; then echo 'HTML_COLORSTYLE = LIGHT' >>"$OUT/Doxyfile"; fi
doxygen "$OUT/Doxyfile"
# As texts, which every browser shows.
find samples -name '*.[ch]pp' -o -name '*.py' -o -name '*.ipynb' | while read -r sample; do
    mkdir -p "$OUT/html/$(dirname "$sample")"
    cp "$sample" "$OUT/html/$sample.txt"
done
say "$OUT/html/index.html"
