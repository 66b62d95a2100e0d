#!/bin/sh
# Calls of every object in any order, by libFuzzer: fuzz.sh [SECONDS [CLANG [renew]]], of each of f32, f64 and q31 nine tenths of the
# time without sanitizers, which slow it down, the last tenth under them.  It begins with inputs.hex, and fails with
# what has failed; `renew` writes the inputs that reach most to inputs.hex anew.
# shellcheck disable=SC2086
set -eu
seconds=${1:-600} clang=${2:-clang} renew=${3:-}
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/seeds" "$work/kept"
python3 - "$here/inputs.hex" "$work/seeds" <<'END'
import pathlib, sys
for k, line in enumerate(open(sys.argv[1])):
    pathlib.Path(sys.argv[2], f"{k}").write_bytes(bytes.fromhex(line))
END

build() { # ARITHMETIC SANITIZERS LEVEL
    more=
    [ "$1" != q31 ] || more=$root/src/kq_filter_f64.c # tables are made of doubles
    $clang -std=c11 -g1 -ffp-contract=off -fno-sanitize-recover=all "-I$root/include" "$3" "-fsanitize=fuzzer$2" \
        "-DKQ_FUZZ_$(echo "$1" | tr a-z A-Z)" "$here/fuzz_objects.c" "$root"/src/kq_*_$1.c $more "$root/src/kq_status.c" -lm -o "$work/fuzz$2"
}

run() { # SANITIZERS SECONDS
    "$work/fuzz$1" -max_len=400 -max_total_time="$2" -print_final_stats=1 -artifact_prefix="$PWD/" "$work/corpus" "$work/seeds" \
        >"$work/said" 2>&1 || { grep -av '^#' "$work/said" && exit 1; }
    grep -a '^stat::number_of' "$work/said" | sed "s/^stat::/$arithmetic$1:/"
}

for arithmetic in f32 f64 q31; do
    mkdir "$work/corpus"
    build $arithmetic "" -O2
    run "" $((seconds * 9 / 10))
    [ -z "$renew" ] || "$work/fuzz" -set_cover_merge=1 -use_counters=0 -max_len=400 "$work/kept" "$work/seeds" "$work/corpus" 2>&1 | tail -1
    build $arithmetic ,address,undefined -O1
    run ,address,undefined $((seconds / 10))
    rm -r "$work/corpus"
done
[ -n "$renew" ] || exit 0
python3 - "$here/inputs.hex" "$work/kept" <<'END'
import pathlib, sys
inputs = sorted((path.read_bytes() for path in pathlib.Path(sys.argv[2]).iterdir()), key=lambda one: (len(one), one))
pathlib.Path(sys.argv[1]).write_text("".join(one.hex() + "\n" for one in inputs))
END
