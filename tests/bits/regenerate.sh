#!/bin/sh
# regenerate.sh [DIRECTORY]: writes expected.inc and expected_nonlinear.inc anew, here or into DIRECTORY.
# Needs a C compiler only.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
to=${1:-$here}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$to"

write() { # FILE SOURCE-OR-FLAG...
    file=$1
    shift
    for arithmetic in f32 f64; do
        ${CC:-cc} -std=c11 -O1 -ffp-contract=off -DKQ_BITS_WRITE \
            -DKQ_BITS_"$(echo "$arithmetic" | tr f F)" -I"$root/include" \
            "$@" "$here/digest.c" "$here/model.c" "$root"/src/kq_*"$arithmetic.c" -lm -o "$work/write"
        "$work/write" >"$work/$arithmetic"
    done
    # of "0x..., /* case, block */" on both sides: the case, then ROW(0x..., 0x...), four a line
    paste -d '@' "$work/f32" "$work/f64" | sed 's|^\(0x[^,]*\), /. \([^,]*\),.*@\(0x[^,]*\), .*|\2@ROW(\1, \3)|' |
        awk -F@ '{ if ($1 != of) { of = $1; n = 0; printf("%s/* %s */", (NR > 1 ? "\n" : ""), of) }
            printf("%s%s", (n++ % 4 ? " " : "\n"), $2) } END { print "" }' >"$to/$file"
}

write expected.inc "$here/bits.c" "$here/beyond.c"
write expected_nonlinear.inc -DKQ_BITS_NONLINEAR "$here/nonlinear.c"
