#!/usr/bin/env bash
# Evidence beside the tests: each part writes its section of build/proof/proof.md, and fails if its goal is missed.
#   tools/proof.sh               all parts
#   tools/proof.sh coverage      statements, branch sides and MC/DC of src, as the unit tests reach them
#   tools/proof.sh static        what gcc -fanalyzer, clang-tidy, cppcheck and its addon for MISRA say of src and of generated C
#   tools/proof.sh formal        bounds of q31's number layer: Frama-C's EVA and WP, Z3, every number of the inverse root and reciprocal; steps of
#                                one to three states by EVA
#   tools/proof.sh faults        turned bits in every object, and sensor faults over a flight of 100,000 rows
#   tools/proof.sh fuzz          ten minutes each of f32, f64 and q31, of calls of all objects in any order, by libFuzzer
#   tools/proof.sh mutation [PART/OF]   a thousand faults of src, which of them the unit tests and vectors miss; or a part of these
#   tools/proof.sh stack         bounds of the stack from the compiler's call graph, beside the measured ones
#   tools/proof.sh time          the dearest calls that a search finds, beside the table's hard inputs (15 minutes)
#   tools/proof.sh soak          KQ_SOAK_STEPS (1e9) steps of ordinary models; P and sums after 100 years; a million steps on a Cortex-M0
# tests/PROOF.md has what was found.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/proof"
all_parts=(coverage static formal faults fuzz stack time soak mutation) share=1/1

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

# A sample of what `kalmanq compile` writes: NAME.c of each line, from an example, with its options
generated() {
    local name model options python="$root/build/test/tools/tests/clean/bin/python"
    kq_quietly "$root/tools/test.sh" tools.wheel # installs it there
    rm -rf "$build/generated"
    mkdir -p "$build/generated"
    while read -r name model options; do
        # shellcheck disable=SC2086
        kq_quietly "$python" -B -m kalmanq compile "$root/tools/kalmanq/examples/$model" \
            -o "$build/generated/$name.c" $options
    done <<EOF
straight_f32 track.toml
straight_q31 track.toml --arith q31
loops_f32 track.toml --loops --robust gate=4
loops_q31 track.toml --loops --arith q31
tunable_f32 track.toml --tunable
lag_f32 constant_velocity.toml --lag 3
student_f64 cart.toml --arith f64 --robust student=4 --nis
smoother_f32 range_bearing.py --smooth 50 --iterate 2
attitude_f32 attitude.py
battery_f32 battery.py
rows_f32 regression.toml
library_f32 track.toml --library
library_q31 track.toml --library --arith q31
equations_f32 range_bearing.py --library
EOF
    rm "$build"/generated/*_test.c
}

# shellcheck disable=SC2329
part_static() {
    generated
    echo "## Static analysis of src/ and of generated C"
    echo
    python3 -B "$root/tests/proof/static.py" "$build"/generated/*.c
}

# shellcheck disable=SC2329
part_faults() {
    local tests="$root/build/test/tests/campaign" status=0 arithmetic
    kq_quietly "$root/tools/test.sh" campaign.flight # and build/test is there
    kq_quietly cmake --build "$root/build/test" --parallel "$(nproc)" --target turned_f32 turned_f64 turned_q31
    echo "## Turned bits"
    for arithmetic in f32 f64 q31; do
        printf '\n%s:\n\n' "$arithmetic"
        "$tests/turned_$arithmetic" 1 || status=$?
    done
    printf '\n## Sensor faults\n\n'
    "$tests/flight" 100000 || status=$?
    return "$status"
}

# shellcheck disable=SC2329
part_fuzz() {
    echo "## Fuzzing"
    echo
    (cd "$build" && "$root/tests/fuzz/fuzz.sh" 600 clang-19) >"$build/fuzz.log" || { cat "$build/fuzz.log" && return 1; }
    sed -n 's/:number_of_executed_units: */ executions: /p' "$build/fuzz.log"
}

# shellcheck disable=SC2329
part_mutation() {
    echo "## Mutation"
    echo
    "$KQ_PYTHON" -B "$root/tests/proof/mutation.py" "$build/mutation" --part "$share" --jobs "$(nproc)"
}

# shellcheck disable=SC2329
part_formal() {
    echo "## Formal"
    echo
    why3 config detect >/dev/null 2>&1
    python3 -B "$root/tests/proof/formal/formal.py"
}

# shellcheck disable=SC2329
part_stack() {
    kq_setup cost
    echo "## Stack"
    echo
    "$KQ_PYTHON" -B "$root/tools/cost/stack.py"
}

# shellcheck disable=SC2329
part_time() {
    kq_setup cost
    echo "## Time"
    echo
    "$KQ_PYTHON" -B "$root/tools/cost/search.py"
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

case ${1:-} in -h | --help) sed -n '2,/^# tests.PROOF/s/^# \{0,1\}//p' "$0" && exit ;; esac
[ $# -gt 0 ] || set -- "${all_parts[@]}"
parts=()
for part in "$@"; do
    case $part in [0-9]*/[0-9]*) share=$part && continue ;; esac
    parts+=("$part")
    declare -F "part_$part" >/dev/null || { echo "proof.sh: no part $part; there are: ${all_parts[*]}" >&2 && exit 1; }
done
[ ${#parts[@]} -gt 0 ] || { echo "proof.sh: $share of which part? mutation has parts" >&2 && exit 1; }
kq_setup_many build unity interpreter proof syntax
mkdir -p "$build"
heading "$@" >"$build/proof.md"
failed=0
set +e # whether a part fails is read below: behind `||` bash would go on within it after what failed
for part in "${parts[@]}"; do
    (set -e && "part_$part") | tee -a "$build/proof.md"
    [ "${PIPESTATUS[0]}" = 0 ] || failed=1
done
echo "The page is build/proof/proof.md."
exit "$failed"
