#!/bin/sh
# runner.sh CORE WORK: run.sh fails a program that never ends, crashes, ends without a report or
# with a status, before and after its "OK"; and passes one that is good.
set -eu
core=$1 work=$2/runner-$1
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$core"
mkdir -p "$work"

try() { # HOW, and what run.sh must say, or nothing if it must pass
    status=0
    # shellcheck disable=SC2086
    $compiler -std=c11 -Os -DHOW="$1" -c "$root/tests/target/misbehave.c" -o "$work/$1.o"
    # shellcheck disable=SC2086
    $linker "$work/$1.o" -o "$work/$1"
    sh "$root/tests/target/run.sh" "$core" "$work/$1" >"$work/$1.log" 2>&1 || status=$?
    said=$(tail -n 1 "$work/$1.log")
    echo "$1: status $status, $said"
    if [ $# = 1 ]; then
        [ $status = 0 ]
    else
        [ $status = 1 ] && echo "$said" | grep -Eq "$2"
    fi
}

try GOOD
try SILENT 'without a report'
for when in '' _AFTER_REPORT; do
    try CRASH$when 'ended with status [1-9]'
    try FAILING$when 'ended with status [1-9]'
    limit=${KQ_TIME_LIMIT:-0}
    export KQ_TIME_LIMIT=1
    try ENDLESS$when 'no end after'
    export KQ_TIME_LIMIT="$limit"
done
export KQ_AVR_CYCLES=1
[ "$core" != avr ] || try ENDLESS 'ended with status 99'
