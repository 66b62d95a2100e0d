#!/usr/bin/env bash
# cross.sh CORE WORK: the consumer's program for a chip, by find_package of an installed library and by FetchContent; it
# runs under an emulator and ends with 0.  CORE is one of tests/target/cores.sh.
set -euo pipefail
core=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
# shellcheck source=tests/target/cores.sh
. "$root/tests/target/cores.sh"
core_select "$core"
rm -rf "$work" && mkdir -p "$work"

# CMake links with the compiler's flags, too: some may not come twice
read -r cc link <<<"$linker"
link=$(tr ' ' '\n' <<<"$link" | grep -vxFf <(tr ' ' '\n' <<<"$compiler") | tr '\n' ' ')
printf '%s\n' 'set(CMAKE_SYSTEM_NAME Generic)' "set(CMAKE_C_COMPILER $cc)" "set(CMAKE_C_FLAGS_INIT \"${compiler#* }\")" \
    'set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)' 'set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)' \
    "set(CMAKE_EXE_LINKER_FLAGS_INIT \"$link\")" >"$work/toolchain.cmake"
toolchain="-DCMAKE_TOOLCHAIN_FILE=$work/toolchain.cmake"

cmake -S "$root" -B "$work/library" "$toolchain" -DKALMANQ_BUILD_TESTS=OFF -DKALMANQ_ARITHMETICS="f32;f64" \
    -DCMAKE_INSTALL_PREFIX="$work/prefix" >"$work/library.txt"
cmake --build "$work/library" -j2 --target install >>"$work/library.txt"
for way in find_package fetch_content; do
    cmake --no-warn-unused-cli -S "$here/consumer" -B "$work/$way" "$toolchain" -DWAY=$way -DKALMANQ_SOURCE="$root" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_PREFIX_PATH="$work/prefix" -DKALMANQ_ARITHMETICS="f32;f64" -DFETCHCONTENT_FULLY_DISCONNECTED=ON >"$work/$way.txt"
    cmake --build "$work/$way" -j2 >>"$work/$way.txt"
    # shellcheck disable=SC2086
    timeout "${KQ_TIME_LIMIT:-600}" $emulator "$work/$way/consumer" >"$work/said.txt" 2>&1 </dev/null || { cat "$work/said.txt" && exit 1; }
    cat "$work/said.txt"
    grep -q "^kalmanq [0-9.]*: 3 3 halves" "$work/said.txt"
    echo "$core: $way runs"
done
echo "$core: both ways run"
