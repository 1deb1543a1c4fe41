#!/usr/bin/env bash
# The long run: frames of changing sizes through one object from several threads, calls that fail, memory
# that runs out; then a small run under valgrind's memcheck. See doc/reliability.md.
#
#   scripts/soak.sh [option of aqorb_soak...]
#
# For example --frames=100000 --threads=4 --failures=20000, which are the defaults.
source "$(dirname "$0")/common.sh"

need build-essential cmake libopencv-dev libgtest-dev valgrind

say "Building"
configure "$BUILD/release" -DAQORB_BUILD_TESTS=ON >/dev/null
build "$BUILD/release" --target aqorb_soak

say "The long run"
"$BUILD/release/tools/soak/aqorb_soak" "$@"

# memcheck NAME=VALUE...: a small run in an environment. The operator new is that of the program.
memcheck() {
    env "$@" valgrind --quiet --error-exitcode=1 --leak-check=full --errors-for-leak-kinds=definite \
        --show-leak-kinds=definite --soname-synonyms=somalloc=nouserintercepts \
        "$BUILD/release/tools/soak/aqorb_soak" --frames=200 --threads=2 --failures=60 --any-memory
}

# Valgrind does not know AVX-512, so the kernels are those for AVX2; then the baseline's.
say "memcheck, AVX2 kernels"
memcheck OPENCV_CPU_DISABLE=
say "memcheck, baseline kernels"
memcheck OPENCV_CPU_DISABLE=AVX2
