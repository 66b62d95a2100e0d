#!/bin/sh
# regenerate.sh [DIRECTORY]: writes the golden vectors anew, into cases/ or into DIRECTORY.
# Needs a C compiler only.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
to=${1:-$here/cases}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$to"
${CC:-cc} -std=c11 -O1 -ffp-contract=off -I"$root/include" "$here/generate.c" \
    "$here/generate_beyond.c" "$here/generate_extended.c" "$here/script.c" "$here/vector.c" "$root"/src/*.c -lm \
    -o "$work/generate"
"$work/generate" "$to"
