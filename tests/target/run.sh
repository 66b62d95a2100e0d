#!/bin/sh
# run.sh CORE PROGRAM [SECONDS]: runs a program on the core's emulator.  It passes only if it
# ends within its time, with exit status 0, and its last line is "OK" (as Unity's is).
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$1"
program=$2 seconds=${3:-60}

fail() {
    echo "$core: $(basename "$program"): $1"
    exit 1
}

status=0
# shellcheck disable=SC2086
timeout -k 5 "$seconds" $emulator "$program" >"$program.txt" 2>&1 </dev/null || status=$?
cat "$program.txt"
[ $status != 124 ] || fail "no end after $seconds s"
[ $status = 0 ] || fail "ended with status $status"
[ "$(tail -n 1 "$program.txt" | tr -d '\r')" = OK ] || fail "ended without a report"
