#!/bin/sh
# compile.sh CORE SOURCE WORK: every source file compiles clean, at -O0 to -O3 and -Os, and the
# objects refer to nothing that does not belong there.
set -eu
core=$1 source=$2 work=$3
flags="-std=c11 -fno-math-errno -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Werror"
case $core in
m0 | m3) compiler="arm-none-eabi-gcc -mthumb -mcpu=cortex-$core" ;;
m4f) compiler="arm-none-eabi-gcc -mthumb -mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16" ;;
m7) compiler="arm-none-eabi-gcc -mthumb -mcpu=cortex-m7 -mfloat-abi=hard -mfpu=fpv5-d16" ;;
gcc) compiler=gcc ;;
clang) compiler=$(command -v clang || command -v clang-14) ;;
esac
nm=nm
case $core in m*) nm=arm-none-eabi-nm ;; esac

# What a float object may ask for: memory moves that compilers insert, and soft-float single
# precision where there is no FPU.  Nothing of double, of the heap, of stdio, no assert; on
# hardware floating point the root is an instruction.
allowed='^(mem(cpy|move|set)|__aeabi_mem.*)$'
case $core in
m0 | m3) allowed="$allowed|^__aeabi_(f(add|sub|mul|div|cmp(eq|lt|le|ge|gt|un)|2u?iz)|u?i2f|u?idiv(mod)?)$|^sqrtf$" ;;
esac

for level in -O0 -O1 -O2 -O3 -Os; do
    for file in "$source"/src/*.c; do
        object="$work/$core$level-$(basename "$file").o"
        # shellcheck disable=SC2086
        $compiler $flags $level -I"$source/include" -c "$file" -o "$object"
    done
    [ "$level" = -O2 ] || continue
    object="$work/$core-O2-kq_f32.c.o"
    foreign=$($nm -u "$object" | awk '{print $NF}' | grep -Ev "$allowed" || true)
    if [ -n "$foreign" ]; then
        echo "$core: the float object refers to:" $foreign
        exit 1
    fi
    echo "$core: float object refers to:" $($nm -u "$object" | awk '{print $NF}')
    ! $nm "$object" | grep -E ' [BbDdC] ' || { echo "$core: the object has writable data"; exit 1; }
done
echo "$core: clean"
