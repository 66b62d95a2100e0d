#!/bin/sh
# regenerate.sh [CASE...]: makes the outputs in cases/*.inc anew, of all cases or of those named.
# Needs a C compiler only.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
${CC:-cc} -std=c11 -O1 -I"$root/include" "$here/record.c" "$here/vector.c" "$root"/src/*.c -lm -o "$work/record"
[ $# -gt 0 ] || set -- $(cd "$here/cases" && ls | sed 's/[.]inc$//')
for name; do
    "$work/record" <"$here/cases/$name.inc" >"$work/$name.inc"
    cp "$work/$name.inc" "$here/cases/$name.inc"
done
