#!/usr/bin/env bash
# The demo: sets up what is missing, builds, then estimates noise, filters, forecasts and smooths.
#   tools/demo.sh                                    the Nile, its variances estimated from a poor
#                                                    guess, and a simulated track
#   tools/demo.sh my.csv --model local-level         measurements of your own
#   tools/demo.sh my.csv --model constant-velocity [--q Q] [--r R] [--dt DT] [--range RANGE]
#   tools/demo.sh my.csv --model local-level --estimate    q and r by EM first
#   tools/demo.sh --help                             all options
# Results go to build/demo, or where --out says.
set -eu
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/demo-build"

# shellcheck source=setup.sh
. "$root/tools/setup.sh"
kq_setup build
kq_setup python

kq_quietly cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DKALMANQ_BUILD_TOOLS=ON -DKALMANQ_BUILD_TESTS=OFF
kq_quietly cmake --build "$build" --target kq_demo

export PYTHONDONTWRITEBYTECODE=1
exec "$KQ_PYTHON" "$root/tools/demo/demo.py" --programs "$build/tools/demo" "$@"
