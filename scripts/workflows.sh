#!/usr/bin/env bash
# Checks what no build runs: the workflows, by actionlint and zizmor; which wheels cibuildwheel would build; the recipe of
# conda-forge; and that all files say the same version.
#
#   scripts/workflows.sh
#
# Installs the Debian packages it needs; go and pip fetch the tools.
source "$(dirname "$0")/common.sh"

ACTIONLINT=v1.7.7  # the last one that Debian 12's Go compiles

need workflows
command -v go >/dev/null || need golang-go
cd "$ROOT"

say "The version"
scripts/version.sh

tools=$BUILD/venv/workflows
if ! cmp -s scripts/tools.txt "$tools/tools.txt"; then
    environment "$tools" cibuildwheel py-rattler-build zizmor
    cp scripts/tools.txt "$tools/"
fi
actionlint=$CACHE/actionlint-$ACTIONLINT
[[ -e $actionlint/actionlint ]] ||
    GOBIN=$actionlint GOFLAGS=-modcacherw go install "github.com/rhysd/actionlint/cmd/actionlint@$ACTIONLINT" ||
    die "go could not fetch actionlint; is there a network?"
say "actionlint, zizmor"
"$actionlint/actionlint" .github/workflows/*.yml
"$tools/bin/zizmor" --offline --quiet .github

say "The wheels that cibuildwheel would build"
expected=$(for system in {manylinux,musllinux}_{x86_64,aarch64} macosx_{x86_64,arm64} win_amd64; do
    printf "%s-$system\n" cp3{9,10,11,12,13,14,14t,15,15t}
done | sort)
printed=$(while read -r system processors; do
    "$tools/bin/cibuildwheel" --print-build-identifiers --platform "$system" --archs "$processors"
done <<<'linux x86_64,aarch64
macos x86_64,arm64
windows AMD64' | sort)
diff <(echo "$expected") <(echo "$printed") || die "cibuildwheel would build other wheels than expected"
echo "$(wc -l <<<"$printed") wheels"

say "The recipe of conda-forge"
"$tools/bin/python" - <<'END'
from rattler_build import Stage0Recipe, VariantConfig
conda_forge = VariantConfig.from_yaml('c_stdlib: [sysroot]\npython: ["3.13.* *_cp313"]\n')
recipe, = Stage0Recipe.from_file('packaging/conda/recipe.yaml').render(conda_forge)
print(recipe)
END
