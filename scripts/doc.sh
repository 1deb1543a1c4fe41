#!/usr/bin/env bash
# Builds the documentation as a web site, build/doc/html/index.html, and looks at every page of it in a browser. A
# warning of doxygen, a link that leads nowhere, a page that needs the network and text that is hard to read are errors.
#
#   scripts/doc.sh [--opencv]
#
# If scripts/web.sh has built the page for browsers, the site holds a copy of it and links to that.
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
    options=(-DBUILD_LIST=aqorb -DBUILD_DOCS=ON -DOPENCV_DOWNLOAD_TRIES_LIST=)
    for feature in ADE IPP ITT JASPER JPEG OPENCL OPENEXR OPENJPEG PNG PROTOBUF QUIRC TIFF WEBP; do
        options+=("-DWITH_$feature=OFF")  # none of which Debian's source package holds
    done
    rm -rf "$folder"
    mkdir -p "$folder"
    cmake -S "$OPENCV_SOURCE" -B "$folder" "${options[@]}" -DOPENCV_EXTRA_MODULES_PATH="$ROOT/modules" \
        >"$folder/configure.log" 2>&1 || die "OpenCV's configuration failed; see $folder/configure.log"
    cmake --build "$folder" --target doxygen_cpp >"$folder/doc.log" 2>&1 || die "see $folder/doc.log"
    if grep 'aqorb.*warning:' "$folder/doc.log"; then die "warnings"; fi
    html=$folder/doc/doxygen/html
    [[ -n $(find "$html" -name tutorial_aqorb_slam.html) ]] || die "OpenCV's documentation lacks the tutorials"
    say "$html/index.html"
    exit
fi

export ROOT OUT=$BUILD/doc OPENCV_VERSION VERSION
opencv=/usr/include/opencv4/opencv2
OPENCV_VERSION=$(sed -n 's/^#define CV_VERSION_\(MAJOR\|MINOR\|REVISION\) *\([0-9]*\).*/\2/p' \
    "$opencv/core/version.hpp" | paste -sd.)
VERSION=$("$ROOT/scripts/release.sh" --version)
rm -rf "$OUT"
mkdir -p "$OUT"

# Where OpenCV's own site documents the classes that ours mentions.
doxygen - >"$OUT/opencv.log" 2>&1 <<END
INPUT            = $opencv/core.hpp $opencv/core $opencv/features2d.hpp $opencv/features2d
RECURSIVE        = YES
EXCLUDE_PATTERNS = */cuda/* */hal/* */opencl/* *.inl.hpp
CREATE_SUBDIRS   = YES
CASE_SENSE_NAMES = YES
EXTRACT_ALL      = YES
MACRO_EXPANSION  = YES
PREDEFINED       = __cplusplus=1 CV_EXPORTS= CV_EXPORTS_W= CV_EXPORTS_W_SIMPLE= CV_EXPORTS_W_MAP= CV_WRAP= \
                   CV_OUT= CV_IN_OUT= CV_PROP= CV_PROP_RW= CV_OVERRIDE= CV_DOXYGEN= "CV_EXPORTS_AS(x)=" "CV_WRAP_AS(x)="
GENERATE_HTML    = NO
GENERATE_LATEX   = NO
GENERATE_TAGFILE = "$OUT/opencv.tag"
OUTPUT_DIRECTORY = "$OUT"
END

# doxygen writes members there that it cannot read. And it would take the name of a file in a text for OpenCV's.
sed -i -e '/<member /{:a;/<\/member>/!{N;ba};/<name>operator std::/d}' -e '/<compound kind="file"/,/<\/compound>/d' \
    "$OUT/opencv.tag"

site=$ROOT/doc/site
"$PYTHON" -B "$site/signatures.py" page "$OUT/opencv.tag" "$OUT/python.markdown"
cp "$site/Doxyfile" "$OUT/Doxyfile"
# Newer versions of doxygen follow the browser to dark colours, which the style sheet does not have.
if [[ $(doxygen -g -) == *HTML_COLORSTYLE\ * ]]; then echo 'HTML_COLORSTYLE = LIGHT' >>"$OUT/Doxyfile"; fi
page=$BUILD/web/page
cp "$site/layout.xml" "$OUT/"
[[ -e $page/aqorb.wasm ]] || sed -i '/url="page\//d' "$OUT/layout.xml"
doxygen "$OUT/Doxyfile"
if [[ -e $page/aqorb.wasm ]]; then
    cp -r "$page" "$OUT/html/page"
    sed -i 's/<p id="project" hidden>/<p id="project">/' "$OUT/html/page/index.html"
fi
rm -f "$OUT"/html/dir_*.html  # nothing leads there
# The page of the namespace cv lists all of OpenCV.
sed -i 's/namespacecv\.html/namespacecv_1_1aqorb.html/g' "$OUT"/html/*.html "$OUT"/html/search/*.js
rm -f "$OUT/html/namespacecv.html"
# In examples doxygen takes the names of variables and of std::vector's members for those of OpenCV.
sed -i 's|<a class="code hl_variableRef"[^>]*>\([^<]*\)</a>|\1|g' "$OUT"/html/*.html
"$PYTHON" -B "$site/signatures.py" insert "$OUT/html"
"$PYTHON" -B "$site/search.py" "$OUT/html"
# As texts, which every browser shows.
(cd "$ROOT" && for sample in samples/*.[ch]pp samples/*.py samples/{colmap,collection}/*.py samples/notebook/*.ipynb; do
    mkdir -p "$OUT/html/$(dirname "$sample")"
    cp "$sample" "$OUT/html/$sample.txt"
done)

# The parts of MathJax that draw formulas as vector graphics.
mathjax=/usr/share/javascript/mathjax
for part in MathJax.js extensions jax/element jax/input/TeX jax/output/SVG/{autoload,fonts/TeX,config.js,jax.js}; do
    mkdir -p "$OUT/html/mathjax/$(dirname "$part")"
    cp -rL "$mathjax/$part" "$OUT/html/mathjax/$part"
done

"$PYTHON" -B "$site/check.py" links "$ROOT" "$OUT/html"
"$PYTHON" -B "$site/check.py" pages "$OUT/html" "$OUT/screenshots"
say "$OUT/html/index.html"
