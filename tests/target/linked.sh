#!/bin/sh
# linked.sh LIBRARY WORK: what a program does not use is not linked: the recording of a history, what takes a
# correlated R apart, the roots of Q and P0, with lean sensors what takes a sharp measurement.  What it does
# use is, so that the names are right.
# shellcheck disable=SC2086
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select m3 gcc
library=$1 work=$2/linked
mkdir -p "$work"

names='^(history_record_update|take_correlated|begin_root|take_with_care)$'
expect() { # what of these is linked with the flags that follow
    wanted=$1
    shift
    $compiler $include -std=c11 -O2 "$@" -c "$root/tests/target/linked.c" -o "$work/program.o"
    $linker -Wl,--gc-sections "$work/program.o" "$library/kq_filter_f32.c.o" $libraries -o "$work/program"
    found=$($nm "$work/program" | awk '{ print $NF }' | sed 's/[.].*//' | grep -E "$names" |
        sort -u | tr '\n' ' ')
    echo "linked $*: $found"
    [ "$found" = "$wanted" ] || { echo "expected: $wanted"; exit 1; }
}
expect 'take_with_care '
expect 'history_record_update take_with_care ' -DWITH_HISTORY
expect 'begin_root take_correlated take_with_care ' -DWITH_CORRELATION
expect '' -DLEAN
