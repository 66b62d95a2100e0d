#!/bin/sh
# wheel.sh PYTHON CLEAN WORK: builds the wheel of the studies, and installs it where CLEAN runs.  Nothing is asked of the network.
set -eu
python=$1 clean=$2 work=$3
rm -rf "$work"
"$python" -m pip wheel -q --disable-pip-version-check --no-deps --no-build-isolation -w "$work" "$(dirname "$0")/.."
packages=$("$clean" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
"$python" -m pip install -q --disable-pip-version-check --no-deps --upgrade --target "$packages" "$work"/*.whl
cd /
"$clean" -c 'import kalmanq_studies; print("installed in", kalmanq_studies.__path__[0])'
