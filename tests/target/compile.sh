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

# What an object may ask for: memory moves that compilers insert; in float, soft-float single
# precision where there is no FPU; in fixed point, integer helpers.  Nothing of double, of the
# heap, of stdio, no assert; on hardware floating point the root is an instruction.
memory='^(mem(cpy|move|set)|__aeabi_mem.*)$'
integers='^(__aeabi_(lmul|llsl|llsr|lasr|u?idiv(mod)?|u?lcmp)|__clzsi2)$'
floats='^$'
case $core in
m0 | m3) floats="^__aeabi_(f(add|sub|mul|div|cmp(eq|lt|le|ge|gt|un)|2u?iz)|u?i2f|u?idiv(mod)?)$|^sqrtf$" ;;
esac

check_object() { # name, what it may refer to
    object="$work/$core-O2-$1.c.o"
    refers=$($nm -u "$object" | awk '{print $NF}')
    foreign=$(echo "$refers" | grep -Ev "$memory|$2|^$" || true)
    if [ -n "$foreign" ]; then
        echo "$core: $1 refers to:" $foreign
        exit 1
    fi
    echo "$core: $1 refers to:" $refers
    ! $nm "$object" | grep -E ' [BbDdC] ' || { echo "$core: $1 has writable data"; exit 1; }
}

for level in -O0 -O1 -O2 -O3 -Os; do
    for file in "$source"/src/*.c; do
        object="$work/$core$level-$(basename "$file").o"
        # shellcheck disable=SC2086
        $compiler $flags $level -I"$source/include" -c "$file" -o "$object"
    done
done
check_object kq_f32 "$floats"
check_object kq_q31 "$integers"
check_object misfit_q31 "$integers"
echo "$core: clean"
