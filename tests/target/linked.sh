#!/bin/sh
# linked.sh LIBRARY WORK: what a program does not use is not linked: what can be attached to a filter, robust
# updates and the losses that it does not name, what takes innovations, what takes a correlated R apart, the roots of Q and P0, with lean sensors the full path of
# low-noise measurements.  What it does use is, so that the names are right.  A debug build links no code that only -O2 sees to be dead.
# shellcheck disable=SC2086
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select m4f gcc
library=$1 work=$2/linked
mkdir -p "$work"

names='^(.*_hooks(_f32)?|history_.*|smooth.*|kq_(history|smooth|lag|instant|diffuse|adaptation|freeze|steady|em)_.*'
names="$names|kq_update_robust_f32|update_robust|huber_noise|student_noise|raise_for_jump|update_gated"
names="$names|take_innovations|around_innovations"
names="$names|take_correlated|begin_root|take_with_care)$"
objects=
for part in filter steady adaptation em statistics; do objects="$objects $library/kq_${part}_f32.c.o"; done

link() { # a program with the flags that follow
    $compiler $include -std=c11 -O2 "$@" -c "$root/tests/target/linked.c" -o "$work/program.o"
    $linker -Wl,--gc-sections "$work/program.o" $objects $libraries -o "$work/program"
    found=$($nm "$work/program" | awk '{ print $NF }' | sed 's/[.].*//' | grep -E "$names" |
        sort -u | tr '\n' ' ')
    echo "linked $*: $found"
}
expect() { # what of these is linked with the flags that follow
    wanted=$1
    shift
    link "$@"
    [ "$found" = "$wanted" ] || { echo "expected: $wanted"; exit 1; }
}
expect_hooks() { # of what is attached, with the flag that follows, there are these, and of nothing else
    wanted=$1
    link "$2"
    hooks=$(echo "$found" | tr ' ' '\n' | grep -E '_hooks(_f32)?$' | tr '\n' ' ')
    [ "$hooks" = "$wanted" ] || { echo "expected: $wanted"; exit 1; }
}
expect 'take_with_care '
expect 'begin_root take_correlated take_with_care ' -DWITH_CORRELATION
expect 'begin_root huber_noise kq_update_robust_f32 take_with_care update_robust ' -DWITH_ROBUST
expect 'around_innovations take_innovations take_with_care ' -DWITH_INNOVATIONS
expect '' -DLEAN
expect_hooks 'kq_history_hooks_f32 ' -DWITH_HISTORY
expect_hooks 'kq_lag_hooks_f32 ' -DWITH_LAG
expect_hooks 'kq_instant_hooks_f32 ' -DWITH_INSTANT
expect_hooks 'diffuse_hooks diffuse_tape_hooks kq_history_hooks_f32 ' -DWITH_START
expect_hooks 'kq_adaptation_hooks_f32 ' -DWITH_ADAPTATION
expect_hooks 'kq_freeze_hooks_f32 ' -DWITH_SETTLING

bytes() { # of flash, of the program linked last
    "${nm%nm}size" "$work/program" | awk 'NR == 2 { print $1 + $2 }'
}
expect_bytes() { # COMPILER LEVEL PERCENT FLAG...: with each flag a debug build takes at most so much of what is linked at -O2
    level=$1\ $2 percent=$3 release=$objects
    core_select m4f "$1"
    $compiler $include $profile -std=c11 "$2" -c "$root/src/kq_filter_f32.c" -o "$work/debug.o"
    core_select m4f gcc
    shift 3
    for flag; do
        link "$flag"
        most=$(($(bytes) * percent / 100))
        objects=$work/debug.o
        link "$flag"
        objects=$release
        echo "$level: $(bytes) bytes, at most $most"
        [ "$(bytes)" -le "$most" ] || { echo "too many" && exit 1; }
    done
}
expect_bytes gcc -Og 110 -DLEAN -DWITH_CORRELATION
expect_bytes clang -O1 120 -DLEAN -DWITH_CORRELATION
