#!/bin/sh
# The long fuzz run of the q31 arithmetic on both cores: long.sh [models [seed]].
# KALMANQ_BOUNDS=0.1 also lists the operations that came within 0.1 bit of their bound.
# shellcheck disable=SC2086
set -eu
models=${1:-100000}
seed=${2:-1}
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cc=${CC:-cc}
flags="-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all -I$root/include"
flags="$flags -I$root/tests/checked"
for name in kq_filter_q31 kq_prepare_q31; do
    $cc -std=c11 $flags -include "$root/tests/checked/fixed.h" -c "$root/src/$name.c" \
        -o "$work/$name.o"
done
$cc -std=c11 $flags -ffp-contract=off -c "$root/src/kq_filter_f64.c" -o "$work/kq_filter_f64.o"
$cc -std=gnu11 $flags "$root/tests/fuzz/fuzz_q31.c" "$root/tests/checked/checked.c" "$work"/*.o \
    -lm -o "$work/fuzz_q31"

# Two halves: models 0 .. half - 1, and the rest.
half=$((models / 2))
"$work/fuzz_q31" "$half" "$seed" 0 &
first=$!
"$work/fuzz_q31" $((models - half)) "$seed" "$half"
wait "$first"
