#!/usr/bin/env bash
# Makes the series of patches that would add the module to opencv_contrib, and the text of its pull request, in
# build/contrib. Applies the series to a pristine copy of opencv_contrib and compares; the tree that results is
# build/opencv_contrib.
#
#   scripts/contrib.sh [--release 4]
#   scripts/contrib.sh --copy FOLDER
#
# The tree is that of Debian's source package of OpenCV, or, with --release 4, that of the newest OpenCV 4 from the
# Python package index. scripts/opencv.sh builds OpenCV with it and runs what that build gives.
#
# With --copy it only puts the module into a folder modules, as opencv_contrib would have it: links become files, the
# licence's header is OpenCV's, and what the build against an installed OpenCV and the Python package need is left out.
#
# Installs the Debian packages it needs.
source "$(dirname "$0")/common.sh"

# copy_module FOLDER: puts the module there.
copy_module() {
    local module=$1/aqorb
    rm -rf "$module"
    cp -rL "$ROOT/modules/aqorb" "$module"
    find "$module" -name __pycache__ -prune -exec rm -r {} +
    rm -r "$module"/{test,samples}/CMakeLists.txt "$module/test/exports.cmake" \
        "$module"/samples/{notebook,test}
    grep -rlIZ 'This file is part of aqorb' "$module" | xargs -0 sed -i \
        -e 's/This file is part of aqorb\. .*/This file is part of OpenCV project./' \
        -e 's|of this distribution\.$|of this distribution and at http://opencv.org/license.html.|' \
        -e '/SPDX-License-Identifier/d'
    if grep -rnI "part of aqorb\|SPDX" "$module"; then die "a file has another header than those of opencv_contrib"; fi
}

release=
case ${1:-} in
'') ;;
--copy)
    copy_module "${2:?is a folder}"
    exit
    ;;
--release)
    [[ ${2:-} == 4 ]] || die "--release needs 4"
    release=4
    ;;
*) die "unknown option $1; --help says what there is" ;;
esac

need git
if [[ $release ]]; then
    contrib_release
else
    opencv_source
    CONTRIB_SOURCE=$OPENCV_SOURCE/contrib
fi

series=$BUILD/contrib tree=$BUILD/opencv_contrib text=$ROOT/packaging/contrib/pull_request.md

# The series has the author and the date of this repository's last commit, so that it is the same at every run.
IFS=$'\n' read -r -d '' GIT_AUTHOR_NAME GIT_AUTHOR_EMAIL GIT_AUTHOR_DATE \
    < <(git -C "$ROOT" log -1 --format='%an%n%ae%n%aI%n' && printf '\0') || die "$ROOT is no clone"
export GIT_AUTHOR_NAME GIT_AUTHOR_EMAIL GIT_AUTHOR_DATE GIT_COMMITTER_NAME=$GIT_AUTHOR_NAME
export GIT_COMMITTER_EMAIL=$GIT_AUTHOR_EMAIL GIT_COMMITTER_DATE=$GIT_AUTHOR_DATE
# The repository is beside the tree, because OpenCV's build would write the state of one inside into a source file. The
# user's settings have no effect.
export GIT_CONFIG_GLOBAL=/dev/null GIT_CONFIG_SYSTEM=/dev/null
export GIT_DIR=$series/repository GIT_WORK_TREE=$tree

# commit FILE... <MESSAGE: commits what has changed there.
commit() {
    git add --force -- "$@"
    git commit --quiet --file -
}

say "A series of patches on opencv_contrib"
rm -rf "$series" "$tree"
mkdir -p "$series"
cp -r "$CONTRIB_SOURCE" "$tree"
cd "$tree"
git init --quiet
# Objects for a moment need no compression, and files that .gitattributes calls text stay as they are.
git config core.looseCompression 0
git config core.autocrlf false
git config gc.auto 0
git add --force .
git commit --quiet --message 'opencv_contrib'
git tag pristine

copy_module modules
# Its row in the list of modules, before the first one whose name comes later.
row='- **aqorb**: Uniformly distributed ORB features -- An ORB detector whose keypoints cover the whole image, '
row+='functions that thin out the keypoints of any detector uniformly or measure how they lie, and a fast matcher of '
row+='binary descriptors.'
awk -v row="$row" '/^- \*\*/ && !done && substr($0, 5) > "aqorb" { print row "\n"; done = 1 } { print }' \
    modules/README.md >"$series/README.md"
mv "$series/README.md" modules/README.md

module=modules/aqorb
commit modules/README.md $module/{CMakeLists.txt,README.md,doc,include,src} <<'END'
Add module aqorb: ORB features spread uniformly over the image

AdaptiveQuadtreeORB is a cv::ORB whose keypoints cover the whole image
instead of clustering where the contrast is highest. retainUniform thins
out the keypoints of any detector in the same way (#4185), and
HammingMatcher gives the matches of cv::BFMatcher at least 6 times as
fast with AVX2.
END
commit $module/{test,perf} <<'END'
aqorb: accuracy and performance tests

Each stage is compared with a plain definition of its result, and the
detector with a plain reference, byte for byte. Tests on photographs use
images that opencv_extra has, and are skipped without it.
END
commit $module/{samples,tutorials} <<'END'
aqorb: samples and tutorials

Samples in C++ and Python for stitching, homographies, stereo odometry,
masks and cameras, and tutorials on replacing cv::ORB, on the algorithm,
its parameters, matching and SLAM.
END
commit $module/misc <<'END'
aqorb: tests and settings of the wrappers

Tests of the wrappers for Python, Java and JavaScript, and what the
generators of those for JavaScript and Objective-C ask for.
END
[[ -z $(git status --porcelain --ignored) ]] || die "the series leaves files out: $(git status --short --ignored)"
git diff --check pristine HEAD || die "trailing white space, which opencv_contrib's checks reject"
exported=$(git rev-parse 'HEAD^{tree}')
git format-patch --quiet --no-signature --output-directory "$series" pristine

say "The series on a pristine copy"
git checkout --quiet -B applied pristine
git am --quiet "$series"/*.patch
[[ $(git rev-parse 'HEAD^{tree}') == "$exported" ]] || die "the series does not give what was exported"
git diff --quiet HEAD || die "git am leaves other files than it commits"
git log --reverse --format='%s' --shortstat pristine..

say "The text of the pull request"
# OpenCV's checklist, which Debian's source package has, must be filled in as it is.
template=$CONTRIB_SOURCE/.github/PULL_REQUEST_TEMPLATE.md
if [[ -e $template ]]; then
    while IFS= read -r item; do
        grep -qxF -e "- [x] $item" "$text" || die "$text does not say: $item"
    done < <(sed -n 's/^- \[[ x]\] //p' "$template")
    echo "It fills in each of the $(grep -c '^- \[[ x]\]' "$template") points of OpenCV's checklist."
fi
cp "$text" "$series"
rm -rf "$GIT_DIR"
ls "$series"
