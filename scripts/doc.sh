#!/usr/bin/env bash
# Builds the documentation as a web site, build/doc/html/index.html, with doxygen and the theme doxygen-awesome-css. A
# warning of doxygen is an error, and so is a link in a document that leads nowhere, or a directive that other viewers of
# Markdown would show.
#
#   scripts/doc.sh
#
# Installs the Debian packages it needs.
source "$(dirname "$0")/common.sh"

need doc
# BibTeX finds its files here without TeX's configuration, which is a large package.
export BIBINPUTS=. BSTINPUTS=.

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
find samples -name '*.[ch]pp' -o -name '*.ipynb' | while read -r sample; do
    mkdir -p "$OUT/html/$(dirname "$sample")"
    cp "$sample" "$OUT/html/$sample.txt"
done
say "$OUT/html/index.html"
