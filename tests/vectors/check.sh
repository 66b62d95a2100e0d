#!/bin/sh
# check.sh ARITHMETIC RECORD WORK: the arithmetic's recorded results are what the recorder writes, byte for byte, and
# cases.c has all of them.  RECORD is the program of regenerate.sh, built.
set -eu
record=$2 work=$3/recorded_$1
here=$(cd "$(dirname "$0")" && pwd)
rm -rf "$work"
mkdir -p "$work"

fail() {
    echo "$1"
    exit 1
}

for name in $(sh "$here/regenerate.sh" --names "$1"); do
    "$record" <"$here/cases/$name.inc" >"$work/$name.inc" || fail "$name cannot be recorded"
    grep -q "\"cases/$name.inc\"" "$here/cases.c" || fail "cases.c lacks $name"
    cmp "$here/cases/$name.inc" "$work/$name.inc" ||
        fail "after a change of the arithmetic that is meant: sh tests/vectors/regenerate.sh"
done
echo "$(find "$work" -type f | wc -l) files are as committed, $(cat "$work"/*.inc | wc -c) bytes"
