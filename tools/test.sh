#!/usr/bin/env bash
# All the tests: sets up what is missing, builds, runs everything through CTest.
#   tools/test.sh            everything
#   tools/test.sh -R unit    what CTest selects; any of its options
set -euo pipefail
cd "$(dirname "$0")/.."
. tools/setup.sh
kq_setup build
kq_setup python
kq_setup tests

cmake -S . -B build/test -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DKALMANQ_BUILD_TESTS=ON -DKALMANQ_BUILD_TOOLS=ON -DKALMANQ_PYTHON="$KQ_PYTHON" >build-log.tmp \
    || { cat build-log.tmp; rm -f build-log.tmp; exit 1; }
rm -f build-log.tmp
cmake --build build/test
report=$(mktemp)
status=0
ctest --test-dir build/test --output-on-failure --timeout 300 -j 2 "$@" | tee "$report" || status=$?
passed=$(grep -c ' Passed ' "$report" || true)
failed=$(grep -cE '\*\*\*(Failed|Timeout|Exception|Not Run)' "$report" || true)
rm -f "$report"
echo
echo "What was done: library, tests and tools built in build/test; figures: build/test/figures.txt"
echo "$passed passed, $failed failed"
[ "$status" = 0 ] && [ "$passed" -gt 0 ]
