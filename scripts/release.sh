#!/usr/bin/env bash
# Makes the files of a release that can be made on Debian, in build/release-files, with their checksums, and publishes
# nothing: the source distribution and the wheel for this system, and the site. It fails if a check of these files, or of
# the workflows that make those of all systems, finds anything.
#
#   scripts/release.sh
#   scripts/release.sh --check
#   scripts/release.sh --workflows | --version | --tag TAG | --notes
#
# With --check it runs what .ci/run leaves out because it hardly changes or takes long: the tests of the wheel beside other
# cv2, of other CPUs, compilers and versions of OpenCV, of other programs with the preloaded library, and of the wrapper
# for Java. This takes hours.
#
# With --workflows it checks what no build runs: the workflows, by actionlint and zizmor, and that all files say the same
# version. With --version it prints the version, after that last check. --tag also fails unless TAG is v<version> and
# CHANGELOG.md says when that version was released. --notes prints what CHANGELOG.md says of the version.
#
# Installs the Debian packages it needs; go, npm and pip fetch the rest.
source "$(dirname "$0")/common.sh"
cd "$ROOT"

ACTIONLINT=v1.7.7  # the last one that Debian 12's Go compiles

# check_version: sets VERSION to what CMakeLists.txt says, and fails where another file says another one.
check_version() {
    local file
    VERSION=$(sed -n 's/^project(aqorb VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
    heading=$(grep -m 1 '^## \[' CHANGELOG.md)
    [[ $heading == "## [$VERSION] - "* ]] || die "CMakeLists.txt says $VERSION, CHANGELOG.md $heading"
    grep -qE "^ *version: ${VERSION//./\\.}\$" CITATION.cff ||
        die "CMakeLists.txt says $VERSION, and CITATION.cff another version"
    for file in package.xml packaging/conda/recipe.yaml packaging/vcpkg/aqorb/vcpkg.json photographs/pyproject.toml \
        tools/consumer/CMakeLists.txt; do
        grep -qE "^\W*(version|find_package\(aqorb)[^0-9]*${VERSION//./\\.}\b" "$file" ||
            die "CMakeLists.txt says $VERSION, and $file another version"
    done
}

workflows() {
    local actionlint=$CACHE/actionlint-$ACTIONLINT
    need workflows
    command -v go >/dev/null || need golang-go
    tools zizmor
    [[ -e $actionlint/actionlint ]] ||
        GOBIN=$actionlint GOFLAGS=-modcacherw go install "github.com/rhysd/actionlint/cmd/actionlint@$ACTIONLINT" ||
        die "go could not fetch actionlint; is there a network?"
    say "actionlint, zizmor"
    # It does not know this runner yet.
    "$actionlint/actionlint" -ignore 'label "macos-15-intel" is unknown' .github/workflows/*.yml
    "$TOOLS/zizmor" --offline --quiet .github
}

check() {
    workflows
    local session
    for session in wheel beside offline asan hostile; do scripts/python.sh "$session"; done
    scripts/compatibility.sh
    scripts/dropin.sh
    scripts/opencv.sh --java
    scripts/measure.sh speed --smoke
}

files() {
    local files=$BUILD/release-files
    workflows
    scripts/python.sh wheel
    scripts/doc.sh
    say "The files of version $VERSION"
    rm -rf "$files"
    mkdir -p "$files"
    cp "$BUILD"/wheels/aqorb-"$VERSION"{.tar.gz,-*.whl} "$files"
    tar -czf "$files/site.tar.gz" -C "$BUILD/doc/html" .
    scripts/release.sh --notes >"$files/notes.md"
    cd "$files"
    sha256sum -- * >SHA256SUMS
    wc -c -- *
}

check_version
case ${1:-} in
'') files ;;
--check) check ;;
--workflows) workflows ;;
--version) echo "$VERSION" ;;
--tag)
    [[ ${2:-} == "v$VERSION" ]] || die "the tag is ${2:-not given}, and CMakeLists.txt says $VERSION"
    [[ $heading =~ \ -\ [0-9]{4}-[0-9]{2}-[0-9]{2}$ ]] || die "CHANGELOG.md has no date of this version: $heading"
    ;;
--notes) sed -n "/^## \[$VERSION\]/,/^## \[/{/^## \[/!p}" CHANGELOG.md ;;
*) die "unknown option $1; --help says what there is" ;;
esac
