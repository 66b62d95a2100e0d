#!/bin/sh
# cmake_avr.sh CMAKE WORK: CMake builds the library for AVR, every source file of it.
set -eu
cmake=$1 work=$2/cmake-avr
root=$(cd "$(dirname "$0")/../.." && pwd)
rm -rf "$work"
"$cmake" -S "$root" -B "$work" -DCMAKE_SYSTEM_NAME=Generic -DCMAKE_C_COMPILER=avr-gcc \
    -DCMAKE_C_FLAGS=-mmcu=atmega2560 -DCMAKE_BUILD_TYPE=Release \
    -DKALMANQ_BUILD_TESTS=OFF
"$cmake" --build "$work"
avr-ar t "$work/libkalmanq.a" | sed 's/\.obj$//' | LC_ALL=C sort >"$work/objects"
(cd "$root/src" && ls -- *.c) | LC_ALL=C sort | diff - "$work/objects"
