#!/usr/bin/env bash
# wheel.sh PYTHON WORK: builds the package's wheel, installs it into a virtual environment that has its
# dependencies and nothing else of this project, and runs the tests beside this file there.
set -euo pipefail
python=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
rm -rf "$work/wheel" "$work/clean"
mkdir -p "$work"
"$python" -m pip wheel -q --disable-pip-version-check --no-deps --no-build-isolation -w "$work/wheel" \
    -C build-dir="$work/build" "$root/tools"
"$python" -m venv --without-pip "$work/clean"
clean="$work/clean/bin/python"
packages=$("$clean" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
"$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))' >"$packages/dependencies.pth"
"$python" -m pip install -q --disable-pip-version-check --no-deps --target "$packages" "$work"/wheel/*.whl
cd "$here"
PYTHONDONTWRITEBYTECODE=1 "$clean" -m pytest -q --no-header -p no:cacheprovider --basetemp "$work/files" .
