#!/usr/bin/env bash
# Checks what a release needs, and publishes nothing.
#
#   scripts/release.sh --version  prints the version, and fails where a file says another one
#   scripts/release.sh --check    runs this, and what .ci/run leaves out because it hardly changes or takes long: the
#                                 wheel beside other cv2, other CPUs, compilers and versions of OpenCV, other programs
#                                 with the preloaded library, and the wrapper for Java. This takes hours.
#
# Installs the Debian packages it needs; npm and pip fetch the rest.
source "$(dirname "$0")/common.sh"
cd "$ROOT"

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

check() {
    local session
    version
    scripts/python.sh wheel
    for session in beside offline asan hostile; do scripts/python.sh "$session"; done
    scripts/compatibility.sh
    scripts/dropin.sh
    scripts/opencv.sh --java
    scripts/measure.sh speed --smoke
}

case ${1:-} in
--version) version ;;
--check) check ;;
*) die "'${1:-}' is none of --version, --check; --help says more" ;;
esac
