#!/usr/bin/env bash
# Sets up what is missing, builds the Python package, and runs it.
#   tools/demo.sh                    the Nile's yearly flow, its variances estimated from a poor guess, and a
#                                    track that is simulated, with a gap: filtered, forecast and smoothed in
#                                    each arithmetic; results go to build/demo, or where --out says
#   tools/demo.sh run MODEL.toml MY.csv --plot OUT.png    any command of kalmanq, on data of your own
#   tools/demo.sh --help             kalmanq's commands
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out="$root/build/demo"
if [ "${1:-}" = --out ] && [ $# -ge 2 ]; then out=$2 && shift 2; fi

# shellcheck source=tools/setup.sh
. "$root/tools/setup.sh"
kq_setup tools

# The package, built anew where a source is newer than it
site="$root/build/tools/site"
if [ ! -d "$site" ] || [ -n "$(find "$root/src" "$root/include" "$root/tools/kalmanq" "$root/tools/CMakeLists.txt" \
    "$root/tools/pyproject.toml" -newer "$site" -type f -not -name '*.pyc' -print -quit)" ]; then
    echo "== building the Python package: about a minute of one processor"
    rm -rf "$site"
    kq_with_progress "$KQ_TOOLS_PYTHON" -m pip install -v --disable-pip-version-check --no-deps --no-build-isolation \
        --target "$site" "$root/tools"
fi
kalmanq() { PYTHONPATH="$site" "$KQ_TOOLS_PYTHON" -m kalmanq "$@"; }
if [ $# -gt 0 ]; then kalmanq "$@" && exit 0 || exit $?; fi

examples="$root/tools/kalmanq/examples"
mkdir -p "$out"
cd "$out"
step() { printf '\n== %s\n' "$*"; }

step "The Nile: variances from a poor guess (Durbin and Koopman: 1469.1 and 15099)"
kalmanq fit "$examples/nile_guess.toml" "$examples/nile.csv" --out nile.toml --plot nile_fit.png
for arithmetic in f64 f32 q31; do
    step "The Nile in $arithmetic: filtered, smoothed, ten years ahead"
    kalmanq run nile.toml "$examples/nile.csv" --arith $arithmetic --smooth --forecast 10 \
        --out nile_$arithmetic.csv --plot nile_$arithmetic.png
done
kalmanq compare nile.toml "$examples/nile.csv" --plot nile_compare.png

step "A track in the plane, simulated, with 30 rows without measurements"
kalmanq simulate "$examples/track.toml" -n 200 --seed 4 --gap 90 120 --truth --out track.csv
kalmanq check "$examples/track.toml"
for arithmetic in f64 f32 q31; do
    step "The track in $arithmetic"
    kalmanq run "$examples/track.toml" track.csv --arith $arithmetic --smooth --forecast 20 \
        --out track_$arithmetic.csv --plot track_$arithmetic.png
done
kalmanq compare "$examples/track.toml" track.csv --plot track_compare.png

if [ -f "$site/kalmanq/tune/core.wasm" ]; then
    step "Pages to tune both by hand: open them in a browser"
    kalmanq tune nile.toml "$examples/nile.csv" -o nile_tune.html
    kalmanq tune "$examples/track.toml" track.csv -o track_tune.html
fi

step "Done: $(find . -name '*.csv' | wc -l) tables and $(find . -name '*.png' | wc -l) pictures in ${out#"$root"/}"
