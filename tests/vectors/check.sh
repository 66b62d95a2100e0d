#!/bin/sh
# check.sh GENERATOR WORK: the committed golden vectors are what the generator writes, byte for byte, and
# replay.c has all of them.  GENERATOR is that of regenerate.sh, built.
set -eu
generator=$1 work=$2/regenerated
here=$(cd "$(dirname "$0")" && pwd)
rm -rf "$work"
mkdir -p "$work"
"$generator" "$work"

fail() {
    echo "$1"
    exit 1
}

diff -rq "$here/cases" "$work" ||
    fail "after a change of the arithmetic that is meant: sh tests/vectors/regenerate.sh"
for file in "$here"/cases/*.inc; do
    name=$(basename "$file") size=$(wc -c <"$file")
    grep -q "\"cases/$name\"" "$here/cases.c" || fail "cases.c lacks $name"
    [ "$size" -lt 60000 ] || fail "$name is too large: $size bytes"
done
echo "$(find "$work" -type f | wc -l) files are as committed, $(cat "$work"/*.inc | wc -c) bytes"
