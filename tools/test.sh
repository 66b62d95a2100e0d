#!/usr/bin/env bash
# The tests: installs what they lack, builds what they need, and runs them through CTest.
#   tools/test.sh                    those for every day
#   tools/test.sh --all              all: every core, compiler and level, the whole cost table
#   tools/test.sh core               a house alone: core (src, include, port, tests), host (tools), shelf (packages, examples, studies, costs)
#   tools/test.sh unit.laws vectors  those whose names begin so, everyday ones if there are any
#   tools/test.sh -R regex           what CTest selects by its options
# tests/README.md is their map.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/test"

# shellcheck source=tools/setup.sh
. "$root/tools/setup.sh"

names=() houses=() options=() is_all=
while [ $# -gt 0 ]; do
    case $1 in
    -h | --help) sed -n '2,8s/^# \{0,1\}//p' "$0" && exit ;;
    --all) is_all=1 ;;
    core | host | shelf) houses+=("$1") ;;
    -*) options=("$@") && break ;;
    *) names+=("$1") ;;
    esac
    shift
done

# what tests of a name need beside a compiler; of no name, everything
groups_of() { # [NAME]
    case ${1:-} in
    unit.msan* | fuzz*) echo clang ;;
    unit* | vectors.host.* | vectors.sanitized | vectors.falsified* | vectors.generator*) ;;
    package.port | package.levels) echo cores ;;
    package.cxx) echo clang ;;
    package.sized) echo clang cores ;;
    package.staged | package.onefile*) echo interpreter ;;
    package.fixed_sizes) echo cores tools ;;
    package.sdist) echo tools ;;
    package.wheel) echo wheel ;;
    package.rust.*) echo rust cores ;;
    package.rust) echo interpreter ;;
    package.micropython*) echo micropython cores ;;
    package.cross*) echo cores ;;
    package.checked* | package.reuse | package.platformio | package.zephyr | package.esp-idf | package.cmsis-pack) echo packagers cores ;;
    package.vcpkg) echo interpreter ;;
    package*) echo package cores tools wheel rust micropython packagers ;;
    flags.gcc | flags.gcc.*) ;;
    flags*) echo clang ;;
    house | house.m*) echo interpreter syntax ;;
    readme* | house* | tools.shared*) echo interpreter ;;
    tools) echo tools clang cores cost peers browser ;;
    tools.tune*) echo tools browser ;;
    tools.design* | tools.compile*) echo tools clang cores cost ;;
    host) echo tools clang cores cost peers browser ;;
    boards* | examples*) echo tools cores cost ;;
    tools.fit* | tools.speed) echo tools peers ;;
    studies*) echo tools peers ;;
    tools*) echo tools ;;
    target* | vectors*) echo clang cores ;;
    cost* | parts*) echo clang cores cost ;;
    reference | reference.s* | reference.co* | reference.nonlinear*) echo eigen python scipy ;;
    reference* | campaign*) echo eigen ;;
    em*) echo peers ;;
    peers*) echo tools peers ;;
    example*) echo tools cores python scipy ;;
    core) echo clang cores package python scipy eigen interpreter syntax ${is_all:+ packagers} ;;
    shelf) echo clang cores package python scipy cost peers tools ${is_all:+ wheel rust micropython packagers} ;;
    *) echo clang cores package python scipy cost eigen peers browser tools syntax ${is_all:+ wheel rust micropython packagers} ;;
    esac
}

set_up() {
    local name groups
    mapfile -t groups < <({ [ ${#names[@]} -gt 0 ] || [ ${#houses[@]} -gt 0 ] || groups_of; for name in "${names[@]}" "${houses[@]}"; do groups_of "$name"; done; } |
        tr ' ' '\n' | LC_ALL=C sort -u)
    kq_setup_many build unity ${groups[@]+"${groups[@]}"}
}

configure() {
    kq_quietly cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
        -DKALMANQ_BUILD_TESTS=ON -DKALMANQ_FETCH_UNITY=ON \
        -DKALMANQ_PYTHON="${KQ_PYTHON:-python3}" -DKALMANQ_PEERS_PYTHON="${KQ_PEERS_PYTHON:-python3}" \
        -DKALMANQ_TOOLS_PYTHON="${KQ_TOOLS_PYTHON:-python3}"
}

# The tests that options of CTest select
listed() { ctest --test-dir "$build" -N "$@" | sed -n 's/^ *Test *#[0-9]*: *//p'; }

# sets `selection` to options of CTest, and `tests`
select_tests() {
    local pattern
    pattern=$(printf '|%s' "${names[@]}" | sed 's/[.+]/[&]/g')
    selection=("${options[@]}")
    [ ${#names[@]} -eq 0 ] || selection+=(-R "^(${pattern#|})")
    [ ${#houses[@]} -eq 0 ] || selection+=(-L "^($(IFS='|' && echo "${houses[*]}"))\$")
    if [ -z "$is_all" ] && [ ${#options[@]} -eq 0 ] &&
        [ -n "$(listed "${selection[@]}" -LE matrix)" ]; then
        selection+=(-LE matrix)
    fi
    mapfile -t tests < <(listed "${selection[@]}")
    [ ${#tests[@]} -gt 0 ] || { echo "test.sh: no test of that name" >&2 && exit 1; }
}

# sets `cpu` to the processors' minutes since the shell began, its children's with them.  Not in a
# subshell, whose times begin anew.
read_cpu() {
    times >"$build/times"
    cpu=$(tr 'ms' '  ' <"$build/times" | awk '{ sum += $1 + $2 / 60 + $3 + $4 / 60 } END { printf "%.1f", sum }')
}
minutes() { awk -v seconds="$1" 'BEGIN { printf "%.1f", seconds / 60 }'; }

set_up
configure
select_tests
echo "== building for ${#tests[@]} tests"
begun=$SECONDS built_whole=1
cmake --build "$build" --parallel "$(nproc)" --target "${tests[@]/#/for.}" -- -k 0 || built_whole=0
build_seconds=$((SECONDS - begun))
read_cpu
build_cpu=$cpu

echo "== running ${#tests[@]} tests"
begun=$SECONDS status=0
limit=$(sed -n 's/^KALMANQ_TIME_LIMIT:[A-Z]*=//p' "$build/CMakeCache.txt")
# one more than processors: some tests wait for processes of theirs
ctest --test-dir "$build" --output-on-failure --timeout "$limit" -j "$(($(nproc) + 1))" "${selection[@]}" \
    --output-junit "$build/tests.xml" || status=$?
test_seconds=$((SECONDS - begun))
read_cpu

# what each test printed, without CTest's own lines
log="$build/Testing/Temporary/LastTest.log"
awk '/^[0-9]+\/[0-9]+ Testing: (reference|start|em|target.pair|cost|fuzz)/ { name = $3 }
     /^Output:/ { getline; if (name) print "\n== " name; inside = name != "" ; next }
     /^<end of output>/ { inside = 0; name = "" }
     inside' "$log" >"$build/figures.txt"

count() { sed -n "s/^[[:space:]]*$1=\"\([0-9]*\)\".*/\1/p" "$build/tests.xml" | head -1; }
total=$(count tests) failed=$(count failures)
echo
[ "$built_whole" = 1 ] || echo "Not all could be built: what failed is above, \"FAILED:\"."
echo "Figures are in build/test/figures.txt, all output is in ${log#"$root"/}."
echo "Build: $(minutes $build_seconds) minutes.  Tests: $(minutes $test_seconds) minutes." \
    "Processor time: $build_cpu and $(awk -v a="$cpu" -v b="$build_cpu" 'BEGIN { printf "%.1f", a - b }') minutes."
echo "$((total - failed)) passed, $failed failed"
[ "$status" = 0 ] && [ "$built_whole" = 1 ] && [ "$total" -gt 0 ]
