#!/bin/sh
# check.sh WORK: the committed digests are what regenerate.sh writes, byte for byte.
set -eu
work=$1/regenerated
here=$(cd "$(dirname "$0")" && pwd)
rm -rf "$work"
sh "$here/regenerate.sh" "$work"
for arithmetic in f32 f64; do
    diff -q "$here/expected_$arithmetic.inc" "$work/expected_$arithmetic.inc" || {
        echo "after a change of the arithmetic that is meant: sh tests/bits/regenerate.sh"
        exit 1
    }
done
wc -l "$work"/*.inc
