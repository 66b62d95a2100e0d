#!/bin/sh
# The bits of every core, with every compiler, at every level, ports included: half an hour on two
# cores.  The everyday tests leave out some levels of some cores (tests/CMakeLists.txt).
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
bash -c '. "$0/tools/setup.sh"; kq_setup build; kq_setup tests' "$root"
cmake -S "$root" -B "$root/build/long" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DKALMANQ_BUILD_TESTS=ON -DKALMANQ_EVERY_LEVEL=ON >/dev/null
cmake --build "$root/build/long" --target avr_emulator
ctest --test-dir "$root/build/long" -R '(target|host)[.](compile|kernels)|vectors|bits' \
    --output-on-failure --timeout 600 -j 2
