#!/bin/sh
# replay.sh WORK CORE COMPILER OPTIONS...: links the library's fixed point part alone with the
# golden vectors and replays them, once for each OPTIONS, as "-O0" or "-O1 -DKQ_FALSIFY".
# CORE and COMPILER are those of tests/target/cores.sh.
# shellcheck disable=SC2086
set -eu
work=$1/$2-$3 name=$2 compiler_name=$3
shift 3
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$name" "$compiler_name"
mkdir -p "$work"
warnings="-std=c11 -Wall -Wextra -Wpedantic -Wconversion -Werror"

# The replay itself is freestanding; the main program prints.
compile() { # FILE OBJECT [OPTION...]
    file=$1 object=$2
    shift 2
    $compiler $options $warnings $include "$@" -c "$file" -o "$work/$object.o"
    objects="$objects $work/$object.o"
}

compile_all() {
    objects=
    compile "$here/vector.c" vector -ffreestanding
    compile "$here/replay.c" replay
    library=$(sh "$root/tests/target/library.sh" "$name" "$compiler_name" "$options")
    for file in kq_q31 kq_statistics_q31 misfit_q31 status; do objects="$objects $library/$file.c.o"; done
}

link_and_run() { # PROGRAM
    $linker $options $objects $libraries -o "$work/$1"
    sh "$root/tests/target/run.sh" "$core" "$work/$1" 120
}

# An AVR's pointers reach one case (flash.h).  The three that run for the most seconds are left to
# -Os, which is what an AVR is programmed with.
replay_one_by_one() {
    common=$objects
    for file in "$here"/cases/*.inc; do
        case_name=$(basename "$file" .inc) objects=$common
        case $options-$case_name in
        -Os-*) ;;
        *-sixteen | *-imu | *-dense) continue ;;
        esac
        compile "$here/one_case.c" case -DVECTOR_CASE="$case_name"
        link_and_run "$case_name"
    done
}

for options in "$@"; do
    echo "== $name, $compiler_name $options"
    compile_all
    if [ "$core" = avr ]; then
        replay_one_by_one
    else
        compile "$here/cases.c" cases
        link_and_run all
    fi
done
