#!/bin/sh
# Calls of every object in any order, by libFuzzer under the sanitizers: objects.sh [SECONDS [CLANG [renew]]], for f32 and f64.
# It begins with inputs.hex, and fails with what has failed; `renew` writes the inputs that reach most to inputs.hex anew.
# shellcheck disable=SC2086
set -eu
seconds=${1:-600} clang=${2:-clang} renew=${3:-}
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/corpus" "$work/kept"
python3 - "$here/inputs.hex" "$work/corpus" <<'END'
import pathlib, sys
for k, line in enumerate(open(sys.argv[1])):
    pathlib.Path(sys.argv[2], f"{k}").write_bytes(bytes.fromhex(line))
END
flags="-std=c11 -g -O1 -ffp-contract=off -fno-sanitize-recover=all -I$root/include"
for arithmetic in f32 f64; do
    selected=
    [ $arithmetic = f32 ] || selected=-DKQ_FUZZ_F64
    $clang $flags $selected -fsanitize=fuzzer,address,undefined "$here/fuzz_objects.c" "$root"/src/kq_*_$arithmetic.c \
        "$root/src/kq_status.c" -lm -o "$work/fuzz_$arithmetic"
    "$work/fuzz_$arithmetic" -max_len=3000 -max_total_time="$seconds" -print_final_stats=1 \
        -artifact_prefix="$PWD/" "$work/corpus" >"$work/said" 2>&1 || { grep -v '^#' "$work/said" && exit 1; }
    grep '^stat' "$work/said"
done
[ -n "$renew" ] || exit 0
"$work/fuzz_f32" -set_cover_merge=1 -use_counters=0 -max_len=800 "$work/kept" "$work/corpus" 2>&1 | tail -1
python3 - "$here/inputs.hex" "$work/kept" <<'END'
import pathlib, sys
inputs = sorted((path.read_bytes() for path in pathlib.Path(sys.argv[2]).iterdir()), key=lambda one: (len(one), one))
pathlib.Path(sys.argv[1]).write_text("".join(one.hex() + "\n" for one in inputs))
END
