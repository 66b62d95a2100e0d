#!/bin/sh
# regenerate.sh [DIRECTORY]: writes expected_f32.inc, expected_f64.inc and those of nonlinear runs anew, here or
# into DIRECTORY.  Needs a C compiler only.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
to=${1:-$here}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$to"

write() { # NAME ARITHMETIC SOURCE-OR-FLAG...
    name=$1 arithmetic=$2
    shift 2
    ${CC:-cc} -std=c11 -O1 -ffp-contract=off -DKQ_BITS_WRITE \
        -DKQ_BITS_"$(echo "$arithmetic" | tr f F)" -I"$root/include" \
        "$@" "$here/digest.c" "$here/model.c" "$root"/src/kq_*"$arithmetic.c" -lm -o "$work/write"
    "$work/write" >"$to/expected_$name$arithmetic.inc"
}

for arithmetic in f32 f64; do
    write "" $arithmetic "$here/bits.c" "$here/beyond.c"
    write nonlinear_ $arithmetic -DKQ_BITS_NONLINEAR "$here/nonlinear.c"
done
