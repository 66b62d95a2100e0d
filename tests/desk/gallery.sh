#!/usr/bin/env bash
# gallery.sh DESK_PYTHON PEERS_PYTHON WORK: the gallery's models, fitted by the package, and their log-likelihoods and
# smoothed states by statsmodels, in an environment that has it.
set -euo pipefail
desk=$1 peers=$2 work=$3
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
rm -rf "$work"
mkdir -p "$work"
"$desk" -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation --target "$work/package" "$root/tools"
PYTHONPATH="$work/package" "$desk" -B "$here/gallery_fitted.py" "$work/fitted.json"
"$peers" -B "$here/gallery_peers.py" "$work/fitted.json"
