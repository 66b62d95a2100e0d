#!/bin/sh
# kernels.sh WORK CORE COMPILER OPTIONS...: kernels.c on the core's emulator, once for each OPTIONS.
# shellcheck disable=SC2086
set -eu
work=$1/kernels-$2-$3$(echo "$4" | tr -d " ") name=$2 compiler_name=$3
shift 3
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$name" "$compiler_name"
mkdir -p "$work"
warnings="-std=c11 -Wall -Wextra -Wpedantic -Wconversion -Werror"
for options in "$@"; do
    echo "== $name, $compiler_name $options"
    $compiler $options $warnings $include "-I$root/src" -c "$root/tests/target/kernels.c" \
        -o "$work/kernels.o"
    $linker $options "$work/kernels.o" $libraries -o "$work/kernels"
    sh "$root/tests/target/run.sh" "$core" "$work/kernels" 120
done
