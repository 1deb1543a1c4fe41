#!/usr/bin/env bash
# Makes the patches that would add the module to opencv_contrib, and builds and tests it there, by nothing but OpenCV's
# own build: the accuracy tests, a smoke run of the performance tests, the Python test, and the generators of the other
# wrappers. Then shows that OpenCV's build finds the module in this repository as well.
#
#   scripts/opencv.sh [--patches | --java | --release 4|5]
#
# The script takes the sources of Debian's package. It writes the patches and the text of their pull request to
# build/contrib, and applies the patches to a pristine copy of opencv_contrib, build/opencv_contrib. --patches ends there.
#
# --java compiles the Java wrapper, too, and runs its tests. --release takes the sources of the newest OpenCV 4, or of
# OpenCV 5, from the Python package index. It ends after the Python test, and leaves OpenCV without the module in
# build/opencv-4 or build/opencv-5, for scripts/compatibility.sh.
#
# Installs the Debian packages it needs. OPENCV_TEST_DATA_PATH is passed on to the tests.
source "$(dirname "$0")/common.sh"

release='' java='' patches=''
case ${1:-} in
'') ;;
--patches) patches=yes ;;
--java) java=yes ;;
--release)
    release=${2:-}
    [[ $release =~ ^[45]$ ]] || die "--release needs 4 or 5"
    ;;
*) die "unknown option $1; --help says what there is" ;;
esac

need build test opencv git ${java:+java}
case $release in
4) opencv_release opencv-contrib-python-headless 4 && contrib_source=${OPENCV_SOURCE%/*}/opencv_contrib ;;
5) opencv_release opencv-python-headless 5 && contrib_source='' ;;
*) opencv_source && contrib_source=$OPENCV_SOURCE/contrib ;;
esac

name=${release:+-$release}
opencv=$BUILD/opencv$name log=$BUILD/opencv$name.configure.log
contrib=$BUILD/opencv_contrib$name
module=$contrib/modules/aqorb

# copy_module: puts the module into $contrib as opencv_contrib would have it. Links become files, the licence's header
# becomes OpenCV's, and files for the standalone build and for the Python package are left out.
copy_module() {
    mkdir -p "$contrib/modules"
    cp -rL "$ROOT/modules/aqorb" "$module"
    find "$module" -name __pycache__ -prune -exec rm -r {} +
    rm -r "$module"/{test,samples}/CMakeLists.txt "$module/test/exports.cmake" "$module"/samples/{notebook,test}
    grep -rlIZ 'This file is part of aqorb' "$module" | xargs -0 sed -i \
        -e 's/This file is part of aqorb\. .*/This file is part of OpenCV project./' \
        -e 's|of this distribution\.$|of this distribution and at http://opencv.org/license.html.|' \
        -e '/SPDX-License-Identifier/d'
    if grep -rnI "part of aqorb\|SPDX" "$module"; then die "a file has another header than those of opencv_contrib"; fi
}

# contrib_git ARGUMENT...: git in $contrib. The user's settings have no effect, and no file is a text to be converted.
contrib_git() {
    local author
    mapfile -t author < <(git -C "$ROOT" log -1 --format='%an%n%ae%n%aI')
    env GIT_CONFIG_GLOBAL=/dev/null GIT_CONFIG_SYSTEM=/dev/null GIT_AUTHOR_DATE="${author[2]}" \
        GIT_COMMITTER_DATE="${author[2]}" git -C "$contrib" -c user.name="${author[0]}" -c user.email="${author[1]}" \
        -c core.looseCompression=0 -c core.autocrlf=false -c gc.auto=0 "$@"
}

# commit MESSAGE FILE...: commits them in $contrib.
commit() {
    contrib_git add --force -- "${@:2}"
    contrib_git commit --quiet --message "$1"
}

# make_patches: with the author and the date of this repository's last commit, so that they are the same at every run.
make_patches() {
    local text=$ROOT/packaging/contrib/pull_request.md series=$BUILD/contrib item row exported added=modules/aqorb
    local template=$contrib/.github/PULL_REQUEST_TEMPLATE.md
    say "A series of patches on opencv_contrib"
    rm -rf "$series"
    cp -r "$contrib_source" "$contrib"
    contrib_git init --quiet
    commit opencv_contrib .
    contrib_git tag pristine
    copy_module
    # Its row in the list of modules, before the first one whose name comes later.
    row='- **aqorb**: Uniformly distributed ORB features -- An ORB detector whose keypoints cover the whole image, '
    row+='functions that thin out the keypoints of any detector uniformly or measure how they lie, and a fast matcher '
    row+='of binary descriptors.'
    awk -v row="$row" '/^- \*\*/ && !done && substr($0, 5) > "aqorb" { print row "\n"; done = 1 } { print }' \
        "$contrib_source/modules/README.md" >"$contrib/modules/README.md"
    # The heading and the first paragraph.
    commit "$(sed -n '1s/^# //p' "$text")"$'\n\n'"$(awk -v RS= 'NR == 2' "$text")" \
        modules/README.md $added/{CMakeLists.txt,README.md,doc,include,src}
    commit "aqorb: accuracy and performance tests" $added/{test,perf}
    commit "aqorb: samples and tutorials" $added/{samples,tutorials}
    commit "aqorb: tests and settings of the wrappers" $added/misc
    [[ -z $(contrib_git status --porcelain --ignored) ]] || die "the series leaves files out"
    contrib_git diff --check pristine HEAD || die "trailing white space, which opencv_contrib's checks reject"
    exported=$(contrib_git rev-parse 'HEAD^{tree}')
    contrib_git format-patch --quiet --no-signature --output-directory "$series" pristine

    say "The series on a pristine copy"
    contrib_git checkout --quiet -B applied pristine
    contrib_git am --quiet "$series"/*.patch
    [[ $(contrib_git rev-parse 'HEAD^{tree}') == "$exported" ]] || die "the series does not give what was exported"
    contrib_git diff --quiet HEAD || die "git am leaves other files than it commits"
    contrib_git log --reverse --format='%s' --shortstat pristine..

    say "The text of the pull request"
    # OpenCV's checklist, which Debian's source package has, must be filled in as it is.
    if [[ -e $template ]]; then
        while IFS= read -r item; do
            grep -qxF -e "- [x] $item" "$text" || die "$text does not say: $item"
        done < <(sed -n 's/^- \[[ x]\] //p' "$template")
        echo "It fills in each of the $(grep -c '^- \[[ x]\]' "$template") points of OpenCV's checklist."
    fi
    cp "$text" "$series"
    rm -rf "$contrib/.git"
    ls "$series"
}

rm -rf "$contrib"
if [[ $contrib_source ]]; then make_patches; else copy_module; fi
[[ ! $patches ]] || exit 0

# FindJNI does not know where Debian keeps its JDKs.
if [[ $java && -z ${JAVA_HOME:-} ]]; then
    JAVA_HOME=$(dirname "$(dirname "$(readlink -f "$(command -v javac)")")")
    export JAVA_HOME
fi

modules=aqorb,calib3d,flann,stitching,imgcodecs,ts,highgui,videoio,python3
# The first OpenCV that reads misc/js/gen_dict.json is newer than Debian's.
if [[ $release ]]; then
    modules+=,js_bindings_generator,video targets=(gen_opencv_js_source)
else
    modules+=,java_bindings_generator,objc_bindings_generator targets=(gen_opencv_java_source gen_opencv_objc_source)
fi
[[ ! $java ]] || modules+=,java targets+=(opencv_java opencv_test_java)
[[ $release != 5 ]] || modules=${modules/calib3d/geometry}

# configure_module MODULES-PATH FOLDER: OpenCV with the module of that FOLDER, its tests and all samples.
configure_module() {
    local sample programs=(opencv_test_aqorb opencv_perf_aqorb)
    say "OpenCV with OPENCV_EXTRA_MODULES_PATH=$1"
    configure_opencv "opencv$name" "$1" -G Ninja -DPYTHON3_EXECUTABLE="$PYTHON" -DPYTHON_DEFAULT_EXECUTABLE="$PYTHON" \
        '-DCPU_DISPATCH=SSE4_1;AVX2;AVX512_SKX' -DBUILD_ZLIB=OFF -DBUILD_PNG=OFF -DBUILD_JPEG=OFF \
        -DBUILD_TESTS=ON -DBUILD_PERF_TESTS=ON -DBUILD_EXAMPLES=ON -DBUILD_LIST="$modules"
    [[ $2 ]] || return 0
    # OpenCV drops a module that it cannot build without an error.
    grep -q 'To be built:.* aqorb' "$log" || die "OpenCV does not build aqorb; see $log"
    grep -qxF "OPENCV_MODULE_opencv_aqorb_LOCATION:INTERNAL=$2" "$opencv/CMakeCache.txt" ||
        die "OpenCV does not take aqorb from $2"
    for sample in "$ROOT"/samples/*.cpp; do programs+=("example_aqorb_$(basename "$sample" .cpp)"); done
    ninja -C "$opencv" -t query "${programs[@]}" >/dev/null || die "a program is not built inside OpenCV"
}

rm -f "$opencv/CMakeCache.txt"
configure_module "$contrib/modules" "$module"
build "$opencv" --target opencv_test_aqorb opencv_perf_aqorb opencv_samples_aqorb opencv_python3 "${targets[@]}" 2>&1 |
    tee "$opencv.build.log"
if grep 'aqorb.*warning:' "$opencv.build.log"; then die "warnings in the build inside OpenCV"; fi

say "Accuracy tests"
(cd "$opencv" && bin/opencv_test_aqorb)

say "Performance tests, one sample each"
(cd "$opencv" && bin/opencv_perf_aqorb --perf_min_samples=1 --perf_force_samples=1)

say "Samples"
"$opencv/bin/example_aqorb_aqorb_demo" --help
ls "$opencv"/bin/example_aqorb_*

say "Python test"
PYTHONPATH=$opencv/lib/python3:$OPENCV_SOURCE/modules/python/test \
    "$PYTHON" "$module/misc/python/test/test_aqorb.py" -v

# generated FILE TEXT...: that OpenCV's generators have made these.
generated() {
    local text
    for text in "${@:2}"; do
        grep -rqF -- "$text" "$opencv/modules/$1" || die "OpenCV's generator has not made: $text"
        echo "$text"
    done
}

say "Other wrappers"
if [[ $release ]]; then
    generated js_bindings_generator/gen/bindings.cpp 'function("aqorb_retainUniform"' \
        '("aqorb_AdaptiveQuadtreeORB")' '("aqorb_HammingMatcher")'
else
    generated java_bindings_generator/gen/java 'class AdaptiveQuadtreeORB extends ORB' \
        'class HammingMatcher extends BFMatcher' 'void retainUniform(' 'void growMatches('
    generated objc_bindings_generator '@interface AdaptiveQuadtreeORB : ORB' \
        '@interface HammingMatcher : BFMatcher' '+ (HammingMatcher*)createHammingMatcher:(NormTypes)normType' \
        '+ (void)retainUniform:'
fi

if [[ $java ]]; then
    say "Java tests"
    # OpenCV's test case warns of a picture that Debian's source does not have.
    for test in "$module"/misc/java/test/*.java; do
        OPENCV_LOG_LEVEL=ERROR "$JAVA_HOME/bin/java" -Djava.library.path="$opencv/lib" \
            -cp "$opencv/java_test/build/classes:$(printf '%s:' "$opencv"/bin/*.jar "$opencv"/java_test/lib/*.jar)" \
            junit.textui.TestRunner "org.opencv.test.aqorb.$(basename "$test" .java)"
    done
fi

# OpenCV itself has been built. What was built of the copy is removed, so that it cannot be taken for the module of this
# repository.
rm -rf "$opencv"/modules/aqorb "$opencv"/lib/libopencv_aqorb*
if [[ $release ]]; then
    configure_module '' ''
    say "Built inside OpenCV $release"
    exit
fi

# These are only configured: but for the licence's header, the files are those that have been built.
for folder in "$ROOT/modules" "$ROOT"; do configure_module "$folder" "$ROOT/modules/aqorb"; done
say "Built inside opencv_contrib, and found in this repository"
