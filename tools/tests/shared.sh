#!/usr/bin/env bash
# shared.sh PYTHON WORK: the shared library, called by ctypes alone: what a binding of any language has.
set -euo pipefail
python=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
cmake -S "$here/../.." -B "$work" -DBUILD_SHARED_LIBS=ON -DKALMANQ_BUILD_TESTS=OFF -DCMAKE_BUILD_TYPE=Debug >"$work.log" 2>&1 &&
    cmake --build "$work" >>"$work.log" 2>&1 || { cat "$work.log" >&2 && exit 1; }
"$python" -B "$here/shared.py" "$work/libkalmanq.so"
