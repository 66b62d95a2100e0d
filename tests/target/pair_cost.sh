#!/bin/sh
# pair_cost.sh WORK: what the pair of floats costs on a Cortex-M4F, in instructions of one
# predict + one full update, run-time sizes, -O2.  "plain" is the same library with the mean
# in one float: mean_pair.h replaced by mean_single.h.
set -eu
work=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select m4f
rm -rf "$work/pair" "$work/plain"
mkdir -p "$work"
cp -r "$root/src" "$work/pair"
cp -r "$root/src" "$work/plain"
cp "$root/src/arithmetic/mean_single.h" "$work/plain/arithmetic/mean_pair.h"

count() {
    # shellcheck disable=SC2086
    $linker -std=c11 -O2 -ffp-contract=fast -fno-math-errno $include \
        "$root/tests/target/pair_cost.c" "$work/$1/kq_filter_f32.c" $libraries \
        -o "$work/$1.elf" 2>"$work/$1.log" || { cat "$work/$1.log"; exit 1; }
    # shellcheck disable=SC2086
    timeout "${KQ_TIME_LIMIT:-0}" $emulator "$work/$1.elf" -icount shift=0 >"$work/$1.txt"
}

count pair
count plain
echo "Cortex-M4F, f32, instructions of predict + update at run-time sizes, gcc -O2"
echo "  n  m   pair  plain  cost of the pair"
paste -d' ' "$work/pair.txt" "$work/plain.txt" | awk '
    { share = 100 * ($3 - $6) / $6
      printf "%3d %2d %6d %6d  %+d (%+.0f %%)\n", $1, $2, $3, $6, $3 - $6, share
      if ($3 == 0 || $6 == 0 || share > 25) bad = 1; lines++ }
    END { exit bad || lines != 6 }'
# as the page has it
said=$(paste -d' ' "$work/pair.txt" "$work/plain.txt" | awk '
    $1 == 2 { printf "%d of %d at n = 2, ", $3 - $6, $3 }
    $1 == 4 { printf "%d of %d at n = 4, m = 2, ", $3 - $6, $3 }
    $1 == 9 { printf "%d of %d at n = 9, m = 3", $3 - $6, $3 }')
tr -s '\n ' ' ' <"$root/tests/README.md" | grep -qF "$said" || { echo "tests/README.md: it is $said" && exit 1; }
