#!/bin/sh
# upgrade.sh ROOT WORK: tools/upgrade.py makes a program of version 0.1 one that compiles, but for one line.
set -e
root=$1 work=$2
mkdir -p "$work"
cp "$root/tests/package/upgrade/old.c" "$work/new.c"
python3 -B "$root/tools/upgrade.py" --write "$work" >"$work/said" && exit 1 # ends with 1: one line is left
grep -q "new.c:26: BY HAND: kq_smoothed_mean" "$work/said"
grep "upgrade: 13 lines changed, 1 left to you" "$work/said"
grep -v kq_smoothed_mean "$work/new.c" | sed 's/^}/    return 0; }/' >"$work/rest.c"
cc -std=c11 -Wall -Wextra -Werror -fsyntax-only -I"$root/include" "$work/rest.c"
