#!/bin/sh
# regenerate.sh [CASE...]: makes the outputs in cases/*.inc anew, of all cases or of those named.
# regenerate.sh --names ARITHMETIC: the cases that there are.
# Needs a C compiler only.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..

names() { # ARITHMETIC
    for file in "$here"/cases/*.inc; do
        name=$(basename "$file" .inc)
        case $1:$name in
        f32:*_f32 | f64:*_f64) echo "$name" ;;
        *:*_f32 | *:*_f64 | f*) ;;
        *) echo "$name" ;;
        esac
    done
}

record() { # ARITHMETIC SOURCE... -- CASE...
    arithmetic=$1 sources=
    shift
    while [ "$1" != -- ]; do sources="$sources $here/$1" && shift; done
    shift
    [ $# -gt 0 ] || return 0
    # shellcheck disable=SC2086 # a list
    ${CC:-cc} -std=c11 -O1 -ffp-contract=off -DVECTOR_"$(echo "$arithmetic" | tr fq FQ)" -I"$root/include" \
        "$here/record.c" "$here/vector.c" $sources "$root"/src/*.c -lm -o "$work/record"
    for name; do
        "$work/record" <"$here/cases/$name.inc" >"$work/$name.inc"
        cp "$work/$name.inc" "$here/cases/$name.inc"
    done
}

chosen() { # ARITHMETIC: of $wanted
    for name in $(names "$1"); do
        case " $wanted " in
        "  " | *" $name "*) echo "$name" ;;
        esac
    done
}

[ "${1:-}" != --names ] || { names "$2" && exit; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
wanted=$*
floats="floats.c floats_model.c floats_filter.c floats_beyond.c floats_nonlinear.c"
# shellcheck disable=SC2046,SC2086 # lists
record q31 q31.c -- $(chosen q31)
for arithmetic in f32 f64; do
    # shellcheck disable=SC2046,SC2086
    record $arithmetic $floats -- $(chosen $arithmetic)
done
