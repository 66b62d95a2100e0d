#!/bin/sh
# check.sh FILE ARITHMETIC PROGRAM WORK: FILE.inc, the committed digests, is what regenerate.sh writes.
# PROGRAM is that of regenerate.sh, built.
set -eu
file=$1 arithmetic=$2 program=$3 written=$4/$1_$2
here=$(cd "$(dirname "$0")" && pwd)
case $arithmetic in
f32) column=1 ;;
*) column=2 ;;
esac
"$program" | sed 's/,.*//' >"$written"
grep -o 'ROW([^)]*)' "$here/$file.inc" | sed "s/ROW(\(.*\), \(.*\))/\\$column/" | cmp - "$written" || {
    echo "after a change of the arithmetic that is meant: sh tests/bits/regenerate.sh"
    exit 1
}
wc -l "$written"
