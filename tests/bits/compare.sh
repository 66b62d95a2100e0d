#!/bin/sh
# compare.sh WORK CORE COMPILER OPTIONS...: links f32 and f64 with bits.c and compares the bits of
# all they answer with the expected ones, once for each OPTIONS, as "-O0" or
# "-O1 -DKQ_BITS_FALSIFY".  CORE and COMPILER are those of tests/target/cores.sh.
# shellcheck disable=SC2086
set -eu
work=$1/$2-$3$(echo "$4" | tr -d " ") name=$2 compiler_name=$3
shift 3
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$name" "$compiler_name"
mkdir -p "$work"
flags="-std=c11 -ffp-contract=off -fno-math-errno -ffunction-sections"
warnings="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Werror"

compare() { # ARITHMETIC
    define=-DKQ_BITS_$(echo "$1" | tr f F)
    # all of it fits into an AVR's flash at -Os, which is what an AVR is programmed with
    case $core$options in
    avr-Os*) ;;
    avr*) define="$define -DKQ_BITS_FILTER" ;;
    esac
    objects=
    for part in $sources; do
        case $part in
        *_"$1".c) objects="$objects $library/$part.o" ;;
        esac
    done
    for file in "$here"/*.c; do
        object="$work/$1-$(basename "$file").o"
        $compiler $options $flags $warnings $define $include -c "$file" -o "$object"
        objects="$objects $object"
    done
    $linker $options $objects $libraries -o "$work/$1"
    sh "$root/tests/target/run.sh" "$core" "$work/$1" 300
}

for options in "$@"; do
    library=$(sh "$root/tests/target/library.sh" "$name" "$compiler_name" "$options")
    for arithmetic in $floating; do
        echo "== $arithmetic, $name, $compiler_name $options"
        compare "$arithmetic"
    done
done
