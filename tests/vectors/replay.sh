#!/bin/sh
# replay.sh WORK WHAT [OPTION...]: builds the library's fixed point part alone with the golden
# vectors and replays them.
#   gcc-O0 gcc-O3 clang-O0 clang-O3    the host's compilers (clang: skipped where there is none)
#   gcc-sanitized                      under the address and undefined-behaviour sanitizers
#   clang-trapped                      undefined behaviour stops the program
#   m0 m3 m4f                          on an emulated Cortex-M
# Options are the compiler's.
# shellcheck disable=SC2086
set -eu
work=$1 what=$2
shift 2
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
flags="$* -std=c11 -Wall -Wextra -Wpedantic -Wconversion -Werror -I$root/include"
files="$here/cases.c $here/replay.c $root/src/kq_q31.c $root/src/misfit_q31.c $root/src/status.c"
program="$work/replay-$what"
skipped=77
mkdir -p "$work"

# The replay itself is freestanding; the main program prints.
build() {
    objects=
    for file in "$here/vector.c" $files; do
        freestanding=
        [ "$file" = "$here/vector.c" ] && freestanding=-ffreestanding
        "$@" $flags $freestanding -c "$file" -o "$program-$(basename "$file").o"
        objects="$objects $program-$(basename "$file").o"
    done
    "$@" $objects $link -o "$program"
}

link=
case $what in
gcc*) compiler=gcc ;;
clang*)
    compiler=$(command -v clang || command -v clang-14) || { echo "no clang here"; exit $skipped; }
    ;;
m0) compiler="arm-none-eabi-gcc -mthumb -mcpu=cortex-m0" board=mps2-an385 ;;
m3) compiler="arm-none-eabi-gcc -mthumb -mcpu=cortex-m3" board=mps2-an385 ;;
m4f)
    compiler="arm-none-eabi-gcc -mthumb -mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16"
    board=mps2-an386
    ;;
esac

case $what in
*-sanitized)
    build $compiler -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all
    "$program"
    ;;
*-trapped)
    build $compiler -O1 -fsanitize=undefined -fsanitize-trap=all
    "$program"
    ;;
*-O*)
    build $compiler "-O${what#*-O}"
    "$program"
    ;;
*)
    link="$root/port/boards/cortex_m.c -T $root/port/boards/mps2.ld"
    link="$link --specs=rdimon.specs -nostartfiles -Wl,--entry=0"
    build $compiler -O2
    timeout 120 qemu-system-arm -M $board -nographic -semihosting -kernel "$program"
    ;;
esac
