#!/usr/bin/env bash
# Evidence beside the tests: each part writes its section of build/proof/proof.md, and fails if its goal is missed.
#   tools/proof.sh               all parts
#   tools/proof.sh coverage      statements, branch sides and MC/DC of src, as the unit tests reach them
#   tools/proof.sh static        what gcc -fanalyzer, clang-tidy and cppcheck say of src
#   tools/proof.sh fuzz          ten minutes of calls of all objects in any order, by libFuzzer, in f32 and in f64
#   tools/proof.sh stack         bounds of the stack from the compiler's call graph, beside the measured ones
#   tools/proof.sh soak          KQ_SOAK_STEPS (1e9) steps of ordinary models; P and sums after 100 years; a million steps on a Cortex-M0
# tests/PROOF.md has what was found.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/proof"
all_parts=(coverage static fuzz stack soak)

# shellcheck source=tools/setup.sh
. "$root/tools/setup.sh"

# Parts are called by their names.
# shellcheck disable=SC2329
build_coverage() {
    kq_quietly cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DKALMANQ_BUILD_TESTS=ON \
        -DKALMANQ_FETCH_UNITY=ON -DCMAKE_C_COMPILER=clang-19 -DCMAKE_CXX_COMPILER=clang++-19 \
        "-DCMAKE_C_FLAGS=$(python3 -B "$root/tests/proof/llvm.py")"
    kq_quietly cmake --build "$build" --parallel "$(nproc)" --target unit_f32 unit_f64 unit_fixed_f64 unit_q31
}

# shellcheck disable=SC2329
part_coverage() {
    local status=0
    build_coverage
    echo "## Coverage of src/"
    echo
    python3 -B "$root/tests/proof/coverage.py" "$build" || status=$?
    return "$status"
}

# shellcheck disable=SC2329
part_static() {
    echo "## Static analysis of src/"
    echo
    python3 -B "$root/tests/proof/static.py"
}

# shellcheck disable=SC2329
part_fuzz() {
    echo "## Fuzzing"
    echo
    (cd "$build" && "$root/tests/fuzz/objects.sh" 600 clang-19) >"$build/fuzz.log" || { cat "$build/fuzz.log" && return 1; }
    sed -n 's/^stat::number_of_executed_units: */- executions: /p' "$build/fuzz.log"
}

# shellcheck disable=SC2329
part_stack() {
    kq_setup cost
    echo "## Stack"
    echo
    "$KQ_PYTHON" -B "$root/tools/cost/stack.py"
}

# shellcheck disable=SC2329
part_soak() {
    local status=0 tests="$build/soak/tests/campaign" one
    kq_setup_many cores eigen python
    kq_quietly cmake -S "$root" -B "$build/soak" -G Ninja -DCMAKE_BUILD_TYPE=Release -DKALMANQ_BUILD_TESTS=ON -DKALMANQ_FETCH_UNITY=ON
    kq_quietly cmake --build "$build/soak" --target soak sums_f32 sums_f64 sums_q31
    echo "## Soak"
    echo
    nice "$tests/soak" "${KQ_SOAK_STEPS:-1e9}" >"$build/soak.log" || status=1
    grep -E '^FAILED|steps$|passed' "$build/soak.log" | sed 's/^/- /'
    python3 -B "$root/tests/proof/drift.py" "$build/soak.log" "$build/drift.svg"
    "$tests/soak" years >"$build/years.log" || status=1
    sed -n 's/^\(.*passed.*\)/- P for ever: \1/p' "$build/years.log"
    for one in f32 f64 q31; do "$tests/sums_$one" | sed 's/^/- /' || status=1; done
    sh "$root/tests/proof/million.sh" "$build/million" | sed 's/^/- Cortex-M0: /' || status=1
    return "$status"
}

# what a page has to name: when, of what, by what
heading() {
    echo "# Evidence"
    echo
    echo "$(date +%F), \`tools/proof.sh $*\`, of $(git -C "$root" describe --always --dirty 2>/dev/null || echo "no repository")."
    echo "$(clang-19 --version | sed -n 1p); $(llvm-cov-19 --version | sed -n 's/^ *//; s/^.*LLVM version/llvm-cov/p')."
    echo
}

case ${1:-} in -h | --help) sed -n '2,9s/^# \{0,1\}//p' "$0" && exit ;; esac
[ $# -gt 0 ] || set -- "${all_parts[@]}"
for part in "$@"; do
    declare -F "part_$part" >/dev/null || { echo "proof.sh: no part $part; there are: ${all_parts[*]}" >&2 && exit 1; }
done
kq_setup_many build unity interpreter proof
mkdir -p "$build"
heading "$@" >"$build/proof.md"
failed=0
for part in "$@"; do
    "part_$part" | tee -a "$build/proof.md" || failed=1
done
echo "The page is build/proof/proof.md."
exit "$failed"
