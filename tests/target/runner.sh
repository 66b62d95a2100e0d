#!/bin/sh
# runner.sh CORE WORK: run.sh fails a program that never ends, crashes, ends without a report or
# with a status, before and after its "OK"; and passes one that is good.
set -eu
core=$1 work=$2/runner-$1
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$core"
mkdir -p "$work"

try() { # HOW, seconds, and what run.sh must say, or nothing if it must pass
    status=0
    # shellcheck disable=SC2086
    $compiler -std=c11 -Os -DHOW="$1" -c "$root/tests/target/misbehave.c" -o "$work/$1.o"
    # shellcheck disable=SC2086
    $linker "$work/$1.o" -o "$work/$1"
    sh "$root/tests/target/run.sh" "$core" "$work/$1" "$2" >"$work/$1.log" 2>&1 || status=$?
    said=$(tail -n 1 "$work/$1.log")
    echo "$1: status $status, $said"
    if [ $# = 2 ]; then
        [ $status = 0 ]
    else
        [ $status = 1 ] && echo "$said" | grep -Eq "$3"
    fi
}

try GOOD 20
try SILENT 20 'without a report'
for when in '' _AFTER_REPORT; do
    try ENDLESS$when 1 'no end after'
    try CRASH$when 20 'ended with status [1-9]'
    try FAILING$when 20 'ended with status [1-9]'
done
export KQ_AVR_CYCLES=1
[ "$core" != avr ] || try ENDLESS 20 'ended with status 99'
