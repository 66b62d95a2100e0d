#!/bin/sh
# fixed_sizes.sh SOURCE WORK BUILD PYTHON: a project with a file of `kalmanq design --way sizes` builds by FetchContent,
# and runs; installed, too; for a Cortex-M0, whose sqrtf is in libm, it links, with what is listed in KALMANQ_ARITHMETICS
# compiled and nothing else.
set -eu
source=$1 work=$2 library=$3
consumer=$(cd "$(dirname "$0")/sizes" && pwd) design=$2/design
rm -rf "$work"
mkdir -p "$design"
"$4" -m kalmanq design "$source/tools/kalmanq/examples/track.toml" --core m4f --arith f32 --way sizes --out "$design"

build() { # NAME OPTION...
    name=$1
    shift
    cmake -S "$consumer" -B "$work/$name" -G Ninja -DDESIGN="$design" -DCMAKE_BUILD_TYPE=Release \
        -DFETCHCONTENT_FULLY_DISCONNECTED=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON "$@" >"$work/$name.txt"
    cmake --build "$work/$name"
    commands=$work/$name/compile_commands.json
    for flag in -fno-math-errno -ffp-contract=off; do
        grep '"command".*track\.c' "$commands" | grep -q -e "$flag" || { echo "$name: track.c without $flag" && exit 1; }
    done
}

build host -DKALMANQ_SOURCE="$source"
"$work/host/sizes"
! grep -e '_f64\.c' -e '_q31\.c' "$commands" | grep -v kq_range_error_q31
build arm -DKALMANQ_SOURCE="$source" -DCMAKE_TOOLCHAIN_FILE="$source/port/arm-none-eabi.cmake" \
    -DCMAKE_C_FLAGS="-mthumb -mcpu=cortex-m0" -DCMAKE_EXE_LINKER_FLAGS="--specs=nosys.specs -Wl,--gc-sections"
arm-none-eabi-size "$work/arm/sizes"

cmake --install "$library" --prefix "$work/prefix" >"$work/library.txt"
build installed -DCMAKE_PREFIX_PATH="$work/prefix"
"$work/installed/sizes"

if cmake -S "$source" -B "$work/refused" -DKALMANQ_BUILD_TESTS=OFF -DKALMANQ_ARITHMETICS=f16 >"$work/refused.txt" 2>&1
then
    echo "f16 was taken"
    exit 1
fi
grep 'f16 is none; there are f32, f64, q31' "$work/refused.txt"
echo "a design of fixed sizes builds in all three ways"
