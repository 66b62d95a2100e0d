#!/bin/sh
# built.sh KALMANQ NAME CORE FOLDER LIBRARY...: FOLDER/NAME, the example NAME of tools/examples as a program of a core (cores.sh).  Its
# device is what the command KALMANQ writes; LIBRARY...: what it is linked with.
# shellcheck disable=SC2086
set -eu
kalmanq=$1 name=$2 core=$3 folder=$4
shift 4
root=$(cd "$(dirname "$0")/../../.." && pwd)
examples=$root/tools/examples
. "$root/tests/target/cores.sh"
core_select "$core"
flags="-std=c11 -O2 -ffp-contract=off $profile $include"
warnings="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror"

case $name in range_bearing) options="--iterate 4" ;; *) options="" ;; esac
case $core in host) main=$examples/main.c ;; *) main=$root/tools/examples/tests/on_core.c ;; esac
mkdir -p "$folder"
$kalmanq compile "$root/tools/kalmanq/examples/$name.py" --library $options -o "$folder/$name.c"
objects=""
for source in "$folder/$name.c" "$examples/simulate_$name.c" "$examples/simulation.c" "$main"; do
    object=$folder/$(basename "$source" .c).o
    $compiler $flags $warnings "-I$folder" "-I$examples" -c "$source" -o "$object"
    objects="$objects $object"
done
$linker $objects "$@" $libraries -o "$folder/$name"
