#!/usr/bin/env bash
# study.sh DESK_PYTHON WORK: what `kalmanq study heavy-tails` has to show, with many runs of three seeds.
set -euo pipefail
desk=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
rm -rf "$work"
mkdir -p "$work"
"$desk" -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation --target "$work/package" \
    "$root/tools"
PYTHONPATH="$work/package" "$desk" -B "$here/study.py" 1 2 3
