#!/bin/sh
# cmake_avr.sh CMAKE WORK: CMake builds the library for AVR, all that its compiler can do.
set -eu
cmake=$1 work=$2/cmake-avr
root=$(cd "$(dirname "$0")/../.." && pwd)
rm -rf "$work"
"$cmake" -S "$root" -B "$work" -DCMAKE_SYSTEM_NAME=Generic -DCMAKE_C_COMPILER=avr-gcc \
    -DCMAKE_C_FLAGS=-mmcu=atmega2560 -DCMAKE_BUILD_TYPE=Release \
    -DKALMANQ_BUILD_TESTS=OFF -DKALMANQ_BUILD_TOOLS=OFF
"$cmake" --build "$work"
avr-ar t "$work/libkalmanq.a" | sort | tr '\n' ' ' | tee "$work/objects"
expected="kq_adaptation_f32.c.obj kq_adaptation_q31.c.obj kq_em_f32.c.obj kq_f32.c.obj"
expected="$expected kq_models_f32.c.obj kq_q31.c.obj kq_statistics_f32.c.obj"
expected="$expected kq_statistics_q31.c.obj kq_steady_f32.c.obj kq_steady_q31.c.obj"
[ "$(cat "$work/objects")" = "$expected misfit_q31.c.obj status.c.obj " ]
