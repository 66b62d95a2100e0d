#!/bin/sh
# sized.sh INCLUDE LIBRARY WORK: sized.cpp runs, its wrong sizes do not compile, and on a Cortex-M4F its calls are the very
# instructions of C's, with nothing that runs before main.
# shellcheck disable=SC2086
set -eu
here=$(cd "$(dirname "$0")" && pwd)
include=$1 library=$2 work=$3
flags="-Wall -Wextra -Wpedantic -Wconversion -Wold-style-cast -Werror -I$include"
mkdir -p "$work"
for compiler in g++ clang++; do
    for standard in 11 2b; do
        $compiler -std=c++$standard $flags "$here/sized.cpp" "$library" -lm -o "$work/program"
        "$work/program"
    done
    for wrong in 1 2 3 4 5 6 7 8 9 10 11 12 13; do
        if $compiler -std=c++11 -fsyntax-only -I"$include" -DKQ_WRONG=$wrong "$here/sized.cpp" 2>"$work/said"; then
            echo "$compiler compiles wrong size $wrong" && exit 1
        fi
        grep -q 'no matching\|cannot convert\|cannot initialize\|could not bind\|deleted\|ambiguous\|1 to 16 states' "$work/said" ||
            { cat "$work/said" && exit 1; }
    done
done

instructions() { # OBJECT: without addresses
    arm-none-eabi-objdump -d --no-show-raw-insn "$1" | sed -n 's/^ *[0-9a-f]*:\t//p' | sed 's/ <.*//; s/^\.word.*/.word/'
}
# without anchors the place of an object in memory is in no instruction
m4f="-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -fno-exceptions -fno-section-anchors -DKQ_PART"
for level in s 2; do
    arm-none-eabi-g++ $m4f -O$level -std=c++11 $flags -c "$here/sized.cpp" -o "$work/sized.o"
    arm-none-eabi-g++ $m4f -O$level -std=c++11 $flags -DKQ_PLAIN -c "$here/sized.cpp" -o "$work/plain.o"
    instructions "$work/sized.o" >"$work/sized.txt"
    instructions "$work/plain.o" >"$work/plain.txt"
    diff "$work/plain.txt" "$work/sized.txt" || { echo "-O$level: other instructions than C's" && exit 1; }
    if arm-none-eabi-objdump -h "$work/sized.o" | grep init_array; then echo "a constructor runs" && exit 1; fi
    echo "-O$level: $(wc -l <"$work/sized.txt") instructions, with the sizes and without"
    arm-none-eabi-size "$work/plain.o" "$work/sized.o"
done
echo "sizes cost no instruction"
