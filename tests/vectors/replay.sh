#!/bin/sh
# replay.sh WORK CORE COMPILER OPTIONS...: links the library's fixed point part alone with the
# golden vectors and replays them, once for each OPTIONS, as "-O0" or "-O1 -DKQ_FALSIFY".
# CORE and COMPILER are those of tests/target/cores.sh.
# shellcheck disable=SC2086
set -eu
work=$1/$2-$3$(echo "$4" | tr -d " ") name=$2 compiler_name=$3
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
    compile "$here/replay.c" replay
    library=$(sh "$root/tests/target/library.sh" "$name" "$compiler_name" "$options")
    for part in $sources; do
        case $part in
        kq_*q31.c | kq_misfit_q31.c | kq_status.c) objects="$objects $library/$part.o" ;;
        esac
    done
}

link_and_run() { # PROGRAM
    $linker $options $objects $libraries -o "$work/$1"
    sh "$root/tests/target/run.sh" "$core" "$work/$1" 300
}

# The operations of vector.c beyond filter and smoother that a case needs: its VECTOR_TOPICS
topics_of() {
    case $1 in
    on_line) echo 1 ;;
    robust) echo 2 ;;
    start) echo 4 ;;
    statistics) echo 8 ;;
    steady) echo 16 ;;
    adaptation) echo 32 ;;
    *) echo 0 ;;
    esac
}

# An AVR's pointers reach one case (flash.h), and its flash holds the operations of one case.  The
# three that run for the most seconds, and the two whose operations fill more flash than there is at
# -O2 or -O3, are left to -Os, which is what an AVR is programmed with.
replay_one_by_one() {
    common=$objects
    for file in "$here"/cases/*.inc; do
        case_name=$(basename "$file" .inc) objects=$common
        case $options-$case_name in
        -Os-*) ;;
        *-sixteen | *-imu | *-dense | *-steady | *-adaptation) continue ;;
        esac
        topics=$(topics_of "$case_name")
        compile "$here/vector.c" "vector$topics" -ffreestanding -ffunction-sections \
            -DVECTOR_TOPICS="$topics"
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
        compile "$here/vector.c" vector -ffreestanding
        compile "$here/cases.c" cases
        link_and_run all
    fi
done
