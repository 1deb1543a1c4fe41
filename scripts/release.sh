#!/usr/bin/env bash
# Checks what a release needs, and publishes nothing.
#
#   scripts/release.sh --version    prints the version, and fails where a file says another one
#   scripts/release.sh --workflows  checks the workflow of GitHub, which no build runs, by actionlint
#   scripts/release.sh --check      runs both, and what .ci/run leaves out because it hardly changes or takes long: the
#                                   wheel beside other cv2, other CPUs, compilers and versions of OpenCV, other programs
#                                   with the preloaded library, and the wrapper for Java. This takes hours.
#
# Installs the Debian packages it needs; go, npm and pip fetch the rest.
source "$(dirname "$0")/common.sh"
cd "$ROOT"

ACTIONLINT=v1.7.7  # the last one that Debian 12's Go compiles

version() {
    local file version heading
    version=$(sed -n 's/^project(aqorb VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
    heading=$(grep -m 1 '^## \[' CHANGELOG.md)
    [[ $heading == "## [$version] - "* ]] || die "CMakeLists.txt says $version, CHANGELOG.md $heading"
    for file in CITATION.cff photographs/pyproject.toml tools/consumer/CMakeLists.txt; do
        grep -qE "^\W*(version|find_package\(aqorb)[^0-9]*${version//./\\.}\b" "$file" ||
            die "CMakeLists.txt says $version, and $file another version"
    done
    echo "$version"
}

workflows() {
    local actionlint=$CACHE/actionlint-$ACTIONLINT
    need workflows
    [[ -e $actionlint/actionlint ]] ||
        GOBIN=$actionlint GOFLAGS=-modcacherw go install "github.com/rhysd/actionlint/cmd/actionlint@$ACTIONLINT" ||
        die "go could not fetch actionlint; is there a network?"
    say "actionlint"
    "$actionlint/actionlint" .github/workflows/*.yml
}

check() {
    local session
    version
    workflows
    scripts/python.sh wheel
    for session in beside offline asan hostile; do scripts/python.sh "$session"; done
    scripts/compatibility.sh
    scripts/dropin.sh
    scripts/opencv.sh --java
    scripts/measure.sh speed --smoke
}

case ${1:-} in
--version) version ;;
--workflows) workflows ;;
--check) check ;;
*) die "'${1:-}' is none of --version, --workflows, --check; --help says more" ;;
esac
