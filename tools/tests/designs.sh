#!/usr/bin/env bash
# designs.sh TOOLS_PYTHON PYTHON WORK CORE...: designs of five models for the cores, in f32 and q31 each as it is
# recommended, compiled without a warning, run on the emulated cores to the twin's words, and measured.
set -euo pipefail
tools_python=$1 python=$2 work=$3
shift 3
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
rm -rf "$work"
mkdir -p "$work"
PYTHONPATH="$root/tools/cost" PYTHONDONTWRITEBYTECODE=1 "$tools_python" "$here/designed.py" "$work/designs" "$@"
"$python" -B "$root/tools/cost/designs.py" "$work/designs"
