#!/usr/bin/env bash
# wheel.sh PYTHON WORK: builds the package's wheel and installs it into WORK/clean, a virtual environment that has its
# dependencies and nothing else of this project.  Nothing is asked of the network.
set -euo pipefail
python=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
. "$here/environment.sh"
rm -rf "$work/wheel" "$work/clean"
mkdir -p "$work/files"
"$python" -m pip wheel -q --disable-pip-version-check --no-deps --no-build-isolation -w "$work/wheel" "$here/../../tools"
environment "$python" "$work/clean"
"$python" -m pip install -q --disable-pip-version-check --no-deps --target "$packages" "$work"/wheel/*.whl
cd /
"$work/clean/bin/python" -c 'import kalmanq; print("installed in", kalmanq.__path__[0])'
