#!/usr/bin/env bash
# compiled_random.sh DESK_PYTHON WORK: 100 random models in f32 and in q31, compiled or refused by name.
set -euo pipefail
desk=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
rm -rf "$work"
mkdir -p "$work"
"$desk" -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation \
    --target "$work/package" "$root/tools"
PYTHONPATH="$work/package" PYTHONDONTWRITEBYTECODE=1 "$desk" "$here/compiled_random.py" 100
