#!/bin/sh
# part.sh PART T N WHAT HOST WORK LIBRARY [TABLE]: links program.c for a small part with its real memory, runs it on
# the emulator, and compares what it prints with the textbook.
#   PART   atmega328p or m0-4k (tests/target/cores.sh);  T: f32 or q31;  N: states
#   WHAT   step; smooth: with a smoother over the whole run; lean, lean_smooth: of constant tables and a lean
#          sensor
#   HOST   host.c, built;  LIBRARY: directory with the library's objects, built
#   TABLE  tools/cost.csv, if its compiler's major version is the one here: the painted stack may be as deep as its stack_worst, and 32 bytes deeper for the
#          program's own frames (a function that calls the library, a return address); it must not be
#          less than three quarters of it (lean with a smoother: two thirds), or the table is about something else
# shellcheck disable=SC2086
set -eu
part=$1 arithmetic=$2 n=$3 what=$4 host=$5 work=$6/$1-$2-$3-$4 library=$7
root=$(cd "$(dirname "$0")/../../../.." && pwd)
table=${8:-$root/tools/cost.csv} own=32
name=$part
[ "$arithmetic" = f32 ] || name=$part+port
. "$root/tests/target/cores.sh"
core_select "$name"
rm -rf "$work"
mkdir -p "$work"

"$host" voltages >"$work/voltages"
export KQ_AVR_VOLTAGES="$work/voltages"
"$host" tables "$arithmetic" "$n" "$what" >"$work/tables.h"
flags=
case $what in lean*) flags=-DLEAN ;; esac
case $what in *smooth) flags="$flags -DRECORD" ;; esac
$compiler -std=c11 -O2 $profile -Wall -Wextra -Werror $include "-I$work" -DPART_$arithmetic $flags \
    -c "$root/tools/cost/tests/parts/program.c" -o "$work/program.o"
if ! $linker "$work/program.o" "$library"/*.c.o $libraries -o "$work/program" 2>"$work/link"; then
    grep -o "region .* overflowed by .*" "$work/link" || cat "$work/link"
    echo "$part: $arithmetic, n = $n, $what: does not link"
    exit 1
fi
if ! sh "$root/tests/target/run.sh" "$part" "$work/program" >"$work/run"; then
    tail -n 3 "$work/run"
    exit 1
fi

worst=$(awk -F , -v key="$(echo "$part" | sed 's/^atmega.*/avr/; s/-.*//'),$arithmetic,$n,1,runtime,gcc-O2,${what#lean_}" '
    $1 == "core" { for (k = 1; k <= NF; k++) if ($k == "stack_worst") column = k }
    column && index($0, key ",") == 1 { print $column }' "$table")
[ -n "$worst" ] || { echo "$table: has no stack_worst of $part, $arithmetic, n = $n, $what"; exit 1; }
echo "$part, $arithmetic, n = $n, $what:"
"$host" check "$arithmetic" "$n" "$what" "$worst" <"$work/run"
made() { echo "${1##*) }" | sed 's/[.].*//'; } # avr-gcc (GCC) 5.4.0: 5
now=$($compiler --version | head -n 1) of=$(grep -m 1 "^# ${compiler%% *} " "$table")
[ "$(made "$now")" = "$(made "$of")" ] || { echo "skipped: figures are of ${of#\# }, not of $now" && exit 0; }
depth=$(printf '%d' "0x$(sed -n 's/^stack //p' "$work/run" | tr -d '\r')")
[ "$depth" -le $((worst + own)) ] || { echo "the stack is deeper than $worst + $own"; exit 1; }
# a lean program takes low-noise measurements on a short path, and no row of its own with a smoother
case $what in lean_*) least=$((2 * worst / 3)) ;; *) least=$((3 * worst / 4)) ;; esac
[ "$depth" -ge "$least" ] || { echo "the stack is less than $least, of $worst"; exit 1; }
