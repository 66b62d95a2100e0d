#!/bin/sh
# check.sh COMPILER WORK AMOUNT: builds the library with flags that break arithmetic.  Each is refused when it
# is compiled, or kq_self_test answers KQ_ERR_ARITHMETIC (-23).  AMOUNT: everyday; whole: with every flag.
# shellcheck disable=SC2046,SC2086
set -eu
compiler=$1 work=$2 amount=$3
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
[ "$compiler" = clang ] && compiler=$(command -v clang || command -v clang-14)
rm -rf "$work"
mkdir -p "$work"

# What these flags do not concern is compiled once, and not optimised.
compile_integers() { # OPTION...
    integers=
    for part in kq_filter_q31 kq_self_test_q31 kq_status; do
        "$compiler" -std=c11 -O0 -w "$@" -I"$root/include" -c "$root/src/$part.c" \
            -o "$work/$part.o"
        integers="$integers $work/$part.o"
    done
}

# Into the folder OBJECTS, or why not
compile_floats() { # OBJECTS OPTION...
    objects=$work/$1
    shift
    mkdir -p "$objects"
    for part in kq_filter_f32 kq_filter_f64 kq_self_test_f32 kq_self_test_f64; do
        "$compiler" -std=c11 -O1 -w "$@" -I"$root/include" -c "$root/src/$part.c" -o "$objects/$part.o" \
            2>"$work/refused" || return 1
    done
}

link() { # OBJECTS: the program
    "$compiler" -std=c11 -O1 -w -I"$root/include" "$here/self_test.c" "$work/$1"/*.o $integers -lm -o "$work/program"
}

build() { compile_floats other "$@" && link other; } # OPTION...

wrong() {
    echo "$compiler, $1: $2"
    exit 1
}

must_be() { # EXPECTED WHAT [ARGUMENT]
    answers=$("$work/program" ${3:-})
    [ "$answers" = "$1" ] || wrong "$2" "answers $answers, not $1"
    echo "$compiler, $2: $1"
}

must_be_refused_or_found() { # OPTION...
    if build "$@"; then
        must_be "-23 -23 0" "$*"
    else
        grep -q 'kalmanq.*: compile with\|kalmanq.*: no -f' "$work/refused" || wrong "$*" "no reason"
        echo "$compiler, $*: refused"
    fi
}

compile_integers
{ compile_floats plain -O0 && link plain; } || wrong "no flags" "does not build"
must_be "0 0 0" "no flags"
must_be "-23 -23 0" "rounding upward" upward

# as older versions of compilers have it: nothing tells the headers
blind="-U__FAST_MATH__ -U__FINITE_MATH_ONLY__ -D__FINITE_MATH_ONLY__=0 -U__ASSOCIATIVE_MATH__"
must_be_found() { # OPTION...: untold
    build "$@" $blind || wrong "$*, untold" "does not build"
    must_be "-23 -23 0" "$*, untold"
}
for flags in -ffast-math -ffinite-math-only; do must_be_refused_or_found $flags; done
# floats in registers of 80 bits; clang has no such flag for this machine
case $compiler-$(uname -m) in gcc-x86_64) must_be_refused_or_found -mfpmath=387 ;; esac
if [ "$amount" = whole ]; then
    must_be_found -ffast-math
    for flags in -funsafe-math-optimizations "-fassociative-math -fno-signed-zeros -fno-trapping-math"; do
        must_be_refused_or_found $flags
        must_be_found $flags
    done
    must_be_found -ffinite-math-only
fi

# a port with a shift that cuts instead of rounding
mkdir -p "$work/port/kalmanq/port"
sed 's/(a + (INT64_C(1) << (shift - 1))) >> shift/a >> shift/' "$root/include/kalmanq/port/integer.h" \
    >"$work/port/kalmanq/port/integer.h"
cmp -s "$root/include/kalmanq/port/integer.h" "$work/port/kalmanq/port/integer.h" &&
    wrong "a broken port" "is not broken"
compile_integers -I"$work/port"
link plain || wrong "a broken port" "does not build"
must_be "0 0 -23" "a broken port"

# library and application do not agree on the length of an enumeration
libraries=-fshort-enums
[ "$amount" = everyday ] || libraries="$libraries -fno-short-enums"
for library in $libraries; do
    other=-fshort-enums
    [ $library = $other ] && other=-fno-short-enums
    objects=
    for part in kq_filter_f64 kq_prepare_q31 kq_range_error_q31 kq_status; do
        "$compiler" -std=c11 -O0 -w $library -I"$root/include" -c "$root/src/$part.c" \
            -o "$work/$part.o"
        objects="$objects $work/$part.o"
    done
    "$compiler" -std=c11 -O1 -w $other -I"$root/include" "$here/enumerations.c" $objects -lm \
        -o "$work/enumerations"
    "$work/enumerations" || wrong "library $library, application $other" "do not understand each other"
done
