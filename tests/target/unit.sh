#!/bin/sh
# unit.sh CORE UNITY WORK: the unit tests, built for the core and run on its emulator, one program
# for each suite and arithmetic.  UNITY: where unity.c is.
#
# avr-gcc 5 has no double of 64 bits: no f64 there, and no preparation of q31's tables from doubles,
# which all of q31's suites begin with.  The golden vectors stand for them (tests/vectors).  Its C
# library has no erfc, which "numbers" needs; its flash does not hold "fixed", five sizes unrolled.
# shellcheck disable=SC2086
set -eu
name=$1 unity=$2 work=$3/unit-$1
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$name"
rm -rf "$work"
mkdir -p "$work"

texts="status process sensor filter update forecast smoother changed laws lag point start least_squares
    consistency adaptation models robust steady em fixed numbers"
own="inverse prepare model filter smoother on_line start least_squares consistency adaptation
    models robust steady fixed numbers"
arithmetics="f32 f64" level=-O2 own_level=-O0
if [ "$core" = avr ]; then
    texts=${texts% fixed numbers} own= arithmetics=f32 level=-Os own_level=-Os
fi

flags="-std=c11 -ffp-contract=off $profile"
warnings="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Werror"
tests="-DUNITY_INCLUDE_DOUBLE -DUNITY_DOUBLE_PRECISION=1e-12 -isystem $unity -I$root/src"

library=$(sh "$root/tests/target/library.sh" "$name" gcc $level)/*.o
$compiler -std=c11 $tests -w -Os -c "$unity/unity.c" -o "$work/unity.o"

failed=0
run_suite() { # SUITE, FILE, options
    suite=$1 file=$2
    shift 2
    level=$own_level
    case $suite in fixed*) level=-O1 ;; esac # unrolled
    $compiler $flags $warnings $include $tests "$@" $level -c "$root/tests/unit/$file.c" \
        -o "$work/$suite.o"
    $linker "$work/$suite.o" "$work/unity.o" $library $libraries -o "$work/$suite"
    if sh "$root/tests/target/run.sh" "$core" "$work/$suite" >"$work/$suite.log" 2>&1 &&
        summary=$(tr -d '\r' <"$work/$suite.log" | grep '^[1-9][0-9]* Tests 0 Failures 0 Ignored'); then
        echo "$name $suite: $summary"
    else
        cat "$work/$suite.log"
        echo "$name $suite: failed"
        failed=1
    fi
}

for arithmetic in $arithmetics; do
    suffix=$(echo $arithmetic | tr f F)
    for text in $texts; do
        case $core-$text-$arithmetic in
        m7-fixed-f64 | m4f-fixed-f32 | m33-fixed-f32 | m7-fixed-f32) ;;
        *-fixed-*) continue ;; # kernels unrolled into calls of soft floating point: megabytes
        esac
        run_suite "${text}_$arithmetic" "test_$text" -DKQ_TEST_$suffix
    done
done
for text in $own; do run_suite "${text}_q31" "test_${text}_q31"; done
exit $failed
