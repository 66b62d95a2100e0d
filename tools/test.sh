#!/usr/bin/env bash
# All the tests: sets up what is missing, builds, runs everything through CTest, and prints the
# figures that the tests measured.
#   tools/test.sh            everything
#   tools/test.sh -R unit    what CTest selects by these options
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/test"

# shellcheck source=setup.sh
. "$root/tools/setup.sh"
kq_setup build
kq_setup python
kq_setup cost
kq_setup tests

kq_quietly cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DKALMANQ_BUILD_TESTS=ON -DKALMANQ_BUILD_TOOLS=ON -DKALMANQ_PYTHON="$KQ_PYTHON" \
    -DKALMANQ_PEERS_PYTHON="$KQ_PEERS_PYTHON" -DKALMANQ_FETCH_UNITY=ON
kq_quietly cmake --build "$build"

status=0
ctest --test-dir "$build" --output-on-failure --timeout 1800 -j 2 "$@" \
    --output-junit "$build/tests.xml" || status=$?

# what each test printed, without CTest's own lines
log="$build/Testing/Temporary/LastTest.log"
awk '/^[0-9]+\/[0-9]+ Testing: (reference|start|em|target.pair|cost|fuzz)/ { name = $3 }
     /^Output:/ { getline; if (name) print "\n== " name; inside = name != "" ; next }
     /^<end of output>/ { inside = 0; name = "" }
     inside' "$log" >"$build/figures.txt"
cat "$build/figures.txt"

count() { sed -n "s/^[[:space:]]*$1=\"\([0-9]*\)\".*/\1/p" "$build/tests.xml" | head -1; }
total=$(count tests) failed=$(count failures)
echo
echo "Built the library, its tests and its tools in build/test and ran the tests."
echo "The figures above are in build/test/figures.txt, all output is in ${log#"$root"/}."
echo "$((total - failed)) passed, $failed failed"
[ "$status" = 0 ] && [ "$total" -gt 0 ]
