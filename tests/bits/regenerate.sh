#!/bin/sh
# regenerate.sh [DIRECTORY]: writes expected_f32.inc and expected_f64.inc anew, here or into
# DIRECTORY.  Needs a C compiler only.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
to=${1:-$here}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$to"
for arithmetic in f32 f64; do
    ${CC:-cc} -std=c11 -O1 -ffp-contract=off -DKQ_BITS_WRITE \
        -DKQ_BITS_"$(echo $arithmetic | tr f F)" -I"$root/include" \
        "$here/bits.c" "$here/beyond.c" "$here/digest.c" "$here/model.c" "$here/nonlinear.c" \
        "$root"/src/kq_*"$arithmetic.c" -lm -o "$work/write"
    "$work/write" >"$to/expected_$arithmetic.inc"
done
