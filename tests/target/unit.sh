#!/bin/sh
# unit.sh CORE UNITY WORK: the unit tests, built for the core and run on its emulator, one program
# for each suite and arithmetic.  UNITY: where unity.c is.
#
# avr-gcc 5 has no double of 64 bits: no f64 there, and no preparation of q31's tables from doubles,
# which all of q31's suites begin with.  The golden vectors stand for them (tests/vectors).  Its C
# library has no erfc, which "numbers" needs.
# shellcheck disable=SC2086
set -eu
core=$1 unity=$2 work=$3/unit-$1
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$core"
rm -rf "$work"
mkdir -p "$work"

texts="status process sensor filter update forecast smoother laws numbers"
fixed="inverse prepare model filter smoother numbers"
arithmetics="f32 f64" level=-O2
if [ "$core" = avr ]; then
    texts=${texts% numbers} fixed= arithmetics=f32 level=-Os
fi

flags="-std=c11 -ffp-contract=off -fno-math-errno -ffunction-sections -fdata-sections"
warnings="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Werror"
tests="-DUNITY_INCLUDE_DOUBLE -DUNITY_DOUBLE_PRECISION=1e-12 -isystem $unity -I$root/src"

library=
for file in $sources; do
    $compiler $flags $warnings $include $level -c "$root/src/$file" -o "$work/library-$file.o"
    library="$library $work/library-$file.o"
done
$compiler -std=c11 $tests -w -Os -c "$unity/unity.c" -o "$work/unity.o"

failed=0
run_suite() { # NAME, FILE, options
    name=$1 file=$2
    shift 2
    $compiler $flags $warnings $include $tests "$@" -O1 -c "$root/tests/unit/$file.c" \
        -o "$work/$name.o"
    $linker "$work/$name.o" "$work/unity.o" $library $libraries -o "$work/$name"
    if sh "$root/tests/target/run.sh" "$core" "$work/$name" >"$work/$name.log" 2>&1 &&
        summary=$(tr -d '\r' <"$work/$name.log" | grep '^[1-9][0-9]* Tests 0 Failures 0 Ignored'); then
        echo "$core $name: $summary"
    else
        cat "$work/$name.log"
        echo "$core $name: failed"
        failed=1
    fi
}

for arithmetic in $arithmetics; do
    suffix=$(echo $arithmetic | tr f F)
    for text in $texts; do run_suite "${text}_$arithmetic" "test_$text" -DKQ_TEST_$suffix; done
done
for text in $fixed; do run_suite "${text}_q31" "test_${text}_q31"; done
exit $failed
