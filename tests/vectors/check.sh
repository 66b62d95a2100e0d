#!/bin/sh
# check.sh RECORD WORK: the committed golden vectors are what the recorder writes, byte for byte, and
# replay.c has all of them.  RECORD is the program of regenerate.sh, built.
set -eu
record=$1 work=$2/recorded
here=$(cd "$(dirname "$0")" && pwd)
rm -rf "$work"
mkdir -p "$work"

fail() {
    echo "$1"
    exit 1
}

for file in "$here"/cases/*.inc; do
    name=$(basename "$file")
    "$record" <"$file" >"$work/$name" || fail "$name cannot be recorded"
    grep -q "\"cases/$name\"" "$here/cases.c" || fail "cases.c lacks $name"
done
diff -rq "$here/cases" "$work" ||
    fail "after a change of the arithmetic that is meant: sh tests/vectors/regenerate.sh"
echo "$(find "$work" -type f | wc -l) files are as committed, $(cat "$work"/*.inc | wc -c) bytes"
