#!/bin/sh
# Calls of every object in any order, by libFuzzer: fuzz.sh [SECONDS [CLANG [renew]]], of each of f32, f64 and q31 nine tenths of the
# time without sanitizers, which slow it down, the last tenth under them.  Half of the nine go to inputs of up to 128 bytes, which
# reach 95 % of the edges in a third of the time each, then half to those of up to 400.  It begins with inputs.hex, goes on with the next
# where one has failed, and fails then; `renew` writes inputs.hex anew: 49 kB of the inputs that reach most.
#
# Entropic schedules and traced comparisons are off: they take three quarters of the time, and reach less in it.
# shellcheck disable=SC2086
set -eu
seconds=${1:-600} clang=${2:-clang} renew=${3:-}
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
work=$(mktemp -d) failed=0
trap 'rm -rf "$work"' EXIT
mkdir "$work/seeds" "$work/kept" "$work/none"
python3 - "$here/inputs.hex" "$work/seeds" <<'END'
import pathlib, sys
for k, line in enumerate(open(sys.argv[1])):
    pathlib.Path(sys.argv[2], f"{k}").write_bytes(bytes.fromhex(line))
END

build() { # ARITHMETIC SANITIZERS LEVEL
    more=
    [ "$1" != q31 ] || more=$root/src/kq_filter_f64.c # tables are made of doubles
    $clang -std=c11 -g1 -ffp-contract=off -fno-sanitize-recover=all "-I$root/include" "$3" "-fsanitize=fuzzer$2" -fno-sanitize-coverage=trace-cmp \
        "-DKQ_FUZZ_$(echo "$1" | tr a-z A-Z)" "$here/fuzz_objects.c" "$root"/src/kq_*_$1.c $more "$root/src/kq_status.c" -lm -o "$work/fuzz$2"
}

run() { # SANITIZERS SECONDS LENGTH
    "$work/fuzz$1" -max_len="$3" -max_total_time="$2" -entropic=0 -reload=0 -print_final_stats=1 -artifact_prefix="$PWD/" \
        "$work/corpus" "$work/seeds" >"$work/said" 2>&1 || { failed=1 && grep -av '^#' "$work/said" || true; }
    grep -a '^stat::number_of' "$work/said" | sed "s/^stat::/$arithmetic$1:/"
}

for arithmetic in f32 f64 q31; do
    mkdir "$work/corpus"
    build $arithmetic "" -O2
    run "" $((seconds * 9 / 20)) 128
    run "" $((seconds * 9 / 20)) 400
    if [ -n "$renew" ]; then
        "$work/fuzz" -set_cover_merge=1 -use_counters=0 -max_len=400 "$work/kept" "$work/seeds" "$work/corpus" 2>&1 | tail -1
        cp "$work/fuzz" "$work/fuzz.$arithmetic"
    fi
    build $arithmetic ,address,undefined -O1
    run ,address,undefined $((seconds / 10)) 400
    rm -r "$work/corpus"
done
[ -n "$renew" ] || exit "$failed"
for arithmetic in f32 f64 q31; do # what each of them reaches
    "$work/fuzz.$arithmetic" -merge=1 -use_counters=0 -max_len=400 "-merge_control_file=$work/reached.$arithmetic" "$work/none" "$work/kept" \
        >"$work/said" 2>&1
done
python3 - "$here/inputs.hex" 49000 "$work"/reached.* <<'END'
import pathlib, sys

reached = {}
for control in sys.argv[3:]:
    lines = pathlib.Path(control).read_text().splitlines()
    names = lines[2 : 2 + int(lines[0])]
    for _, k, *edges in (line.split() for line in lines if line.startswith("FT ")):
        reached.setdefault(pathlib.Path(names[int(k)]), set()).update((control, edge) for edge in edges)
data, left, chosen = {path: path.read_bytes() for path in reached}, int(sys.argv[2]), []
while any(reached.values()):
    best = max(sorted(reached), key=lambda path: len(reached[path]) / (len(data[path]) + 1))
    edges = reached.pop(best)
    if len(data[best]) <= left:
        left -= len(data[best])
        chosen.append(data[best])
        reached = {path: rest - edges for path, rest in reached.items()}
chosen.sort(key=lambda one: (len(one), one))
pathlib.Path(sys.argv[1]).write_text("".join(one.hex() + "\n" for one in chosen))
END
exit "$failed"
