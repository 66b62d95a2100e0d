#!/bin/sh
# check.sh [nonlinear_]ARITHMETIC PROGRAM WORK: the committed digests are what regenerate.sh writes, byte for byte.
# PROGRAM is that of regenerate.sh, built.
set -eu
arithmetic=$1 program=$2 written=$3/expected_$1.inc
here=$(cd "$(dirname "$0")" && pwd)
"$program" >"$written"
diff -q "$here/expected_$arithmetic.inc" "$written" || {
    echo "after a change of the arithmetic that is meant: sh tests/bits/regenerate.sh"
    exit 1
}
wc -l "$written"
