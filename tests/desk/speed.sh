#!/usr/bin/env bash
# speed.sh DESK_PYTHON PEERS_PYTHON WORK: a million steps of n = 4, m = 2 in f64, and the same by filterpy and
# statsmodels, in turns.
set -euo pipefail
desk=$1 peers=$2 work=$3
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
rm -rf "$work"
mkdir -p "$work"
"$desk" -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation --target "$work/package" "$root/tools"
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
PYTHONPATH="$work/package" "$desk" -B "$here/speed.py" "$peers"
