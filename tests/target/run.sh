#!/bin/sh
# run.sh CORE PROGRAM...: runs programs on the core's emulator.  Each passes only if it ends, with exit
# status 0, and its last line is "OK" (as Unity's is).  What does not end is stopped after
# KQ_TIME_LIMIT seconds, if that is given.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$1"
shift

run() { # PROGRAM
    status=0
    # shellcheck disable=SC2086
    timeout -k 5 "${KQ_TIME_LIMIT:-0}" $emulator "$1" >"$1.txt" 2>&1 </dev/null || status=$?
    cat "$1.txt"
    [ $status != 124 ] || fail "$1" "no end after $KQ_TIME_LIMIT s"
    [ $status = 0 ] || fail "$1" "ended with status $status"
    [ "$(tail -n 1 "$1.txt" | tr -d '\r')" = OK ] || fail "$1" "ended without a report"
}

fail() { # PROGRAM, why
    echo "$core: $(basename "$1"): $2"
    exit 1
}

for program in "$@"; do run "$program"; done
