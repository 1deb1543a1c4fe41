#!/usr/bin/env bash
# Prints the version, which CMakeLists.txt says, and fails where another file says another one.
#
#   scripts/version.sh [--tag TAG | --notes]
#
# With --tag it also fails unless TAG is v<version> and CHANGELOG.md says when that version was released.
# With --notes it prints what CHANGELOG.md says of the version.
source "$(dirname "$0")/common.sh"
cd "$ROOT"

version=$(sed -n 's/^project(aqorb VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
heading=$(grep -m 1 '^## \[' CHANGELOG.md)
[[ $heading == "## [$version] - "* ]] || die "CMakeLists.txt says $version, CHANGELOG.md $heading"
for file in CITATION.cff packaging/conda/recipe.yaml; do
    grep -qE "^ *version: ${version//./\\.}\$" "$file" || die "CMakeLists.txt says $version, and $file another version"
done
# The library's name, of Debian's package and on macOS.
grep -oE 'libaqorb\.?[0-9]+\.[0-9]+' doc/installation.md doc/ports.md scripts/package.sh | while IFS=: read -r file name; do
    [[ $name =~ ^libaqorb\.?"${version%.*}"$ ]] || die "CMakeLists.txt says $version, and $file $name"
done

case ${1:-} in
'')
    echo "$version"
    ;;
--tag)
    [[ ${2:-} == "v$version" ]] || die "the tag is ${2:-not given}, and CMakeLists.txt says $version"
    [[ $heading =~ \ -\ [0-9]{4}-[0-9]{2}-[0-9]{2}$ ]] || die "CHANGELOG.md has no date of this version: $heading"
    ;;
--notes)
    sed -n "/^## \[$version\]/,/^## \[/{/^## \[/!p}" CHANGELOG.md
    ;;
*)
    die "unknown option $1; --help says what there is"
    ;;
esac
