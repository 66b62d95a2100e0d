#!/usr/bin/env bash
# vcpkg.sh WORK: the port that tools/package.sh stages, by stand-ins of vcpkg's functions (vcpkg.cmake), and the consumer of
# the package that it makes.
set -euo pipefail
work=$1 here=$(cd "$(dirname "$0")" && pwd)
rm -rf "$work" && mkdir -p "$work"
bash "$here/../../../tools/package.sh" vcpkg
cmake -DPORT="$here/../../../build/packages/vcpkg/kalmanq" -DWORK="$work" -P "$here/vcpkg.cmake"
cmake -S "$here/consumer" -B "$work/consumer" -DWAY=find_package -DCMAKE_PREFIX_PATH="$work/packages" >/dev/null
cmake --build "$work/consumer" >/dev/null
"$work/consumer/consumer"
echo "the port's package is found"
