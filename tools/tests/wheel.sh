#!/usr/bin/env bash
# wheel.sh PYTHON WORK BUILD: builds the package's wheel and installs it into WORK/clean, a virtual environment that has its
# dependencies and nothing else of this project.  Nothing is asked of the network.  BUILD has the library's objects (made.sh).
set -euo pipefail
python=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
. "$here/environment.sh"
rm -rf "$work/wheel" "$work/clean"
mkdir -p "$work/files" "$work/kept"
find "$work/kept" -type f -mtime +7 -delete # what kept/cc has not used for a week
export KQ_MADE=$3 KQ_COMMANDS="$work/commands.txt" CMAKE_C_COMPILER_LAUNCHER="$here/made.sh"
ninja -C "$KQ_MADE" -t commands kalmanq >"$KQ_COMMANDS"
# The progress that pip install -v shows, and what the build takes of a processor
TIMEFORMAT='the wheel: %U seconds of a processor (and %S of the system)'
time "$python" -m pip wheel -v --disable-pip-version-check --no-deps --no-build-isolation -w "$work/wheel" \
    "$here/.." >"$work/wheel.txt" 2>&1 || { cat "$work/wheel.txt" && exit 1; }
grep '\[[0-9]*/[0-9]*\]' "$work/wheel.txt" || echo "nothing to compile"
"$python" "$here/wheel_build.py" "$(find "$here/../../build/tools" -maxdepth 2 -name build.ninja -printf "%T@ %h\n" | sort -n | sed -n '$s/[^ ]* //p')"
environment "$python" "$work/clean"
"$python" -m pip install -q --disable-pip-version-check --no-deps --target "$packages" "$work"/wheel/*.whl
# The base wheel has nothing of the studies
if "$python" -m zipfile -l "$work"/wheel/kalmanq-[0-9]*.whl | grep -E 'studies|lectures|gallery|heavy_tails'; then exit 1; fi
cd /
"$work/clean/bin/python" -c 'import kalmanq; print("installed in", kalmanq.__path__[0])'
