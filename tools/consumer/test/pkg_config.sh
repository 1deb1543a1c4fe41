#!/bin/sh
# pkg_config.sh PREFIX LIBRARY-FOLDER SOURCE PROGRAM: builds and runs a program by the aqorb.pc of a prefix.
set -eu
export PKG_CONFIG_PATH="$1/$2/pkgconfig" LD_LIBRARY_PATH="$1/$2"
# pkg-config writes a space as the shell reads it: with a backslash.
eval "prefix=$($PKG_CONFIG --variable=prefix aqorb)"
[ "$(readlink -f "${prefix:-}")" = "$(readlink -f "$1")" ] || {
    echo "aqorb.pc of $1 has the prefix ${prefix:-}" >&2
    exit 1
}
eval "\$CXX -std=c++11 \"\$3\" -o \"\$4\" $($PKG_CONFIG --cflags --libs aqorb)"
"$4"
