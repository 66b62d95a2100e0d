#!/bin/sh
# port.sh WORK: KALMANQ_PORT puts that port's headers before the portable ones, in what is built and in
# what is installed, and refuses a name that is none.
set -eu
work=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
rm -rf "$work"

configure() { # PORT
    cmake -S "$root" -B "$work/$1" -DKALMANQ_PORT="$1" -DCMAKE_SYSTEM_NAME=Generic \
        -DCMAKE_C_COMPILER=arm-none-eabi-gcc -DCMAKE_C_FLAGS="-mthumb -mcpu=cortex-m0" \
        -DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY -DCMAKE_INSTALL_PREFIX="$work/prefix" \
        -DCMAKE_BUILD_TYPE=Debug -DKALMANQ_BUILD_TESTS=OFF
}

configure armv6m
cmake --build "$work/armv6m" --target install
included=$(tr ' ' '\n' <"$(find "$work/armv6m" -name 'kq_filter_q31.c*.d')" | grep 'kalmanq/port/')
for header in integer vectors; do
    echo "$included" | grep "/port/armv6m/kalmanq/port/$header.h"
    cmp "$root/port/armv6m/kalmanq/port/$header.h" "$work/prefix/include/kalmanq/port/$header.h"
done
if echo "$included" | grep '/include/kalmanq/port/'; then
    echo "a portable header is included beside the port's"
    exit 1
fi

if configure armv9 >"$work/refused" 2>&1; then
    echo "armv9 was taken"
    exit 1
fi
grep 'KALMANQ_PORT=armv9: there is no such port; there are armv6m, armv7m, avr' "$work/refused"
