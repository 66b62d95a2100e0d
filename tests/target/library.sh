#!/bin/sh
# library.sh CORE COMPILER OPTIONS: compiles the library for a core, without a warning, and prints
# the directory of the objects: $KQ_LIBRARIES/CORE-COMPILER.../kq_filter_f32.c.o and so on.  What is there
# and not older than any source is not compiled again: many tests link the same objects.
# shellcheck disable=SC2086
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$1" "$2"
options=$3
to=$KQ_LIBRARIES/$1-$2$(echo "$options" | tr -d ' ')
flags="-std=c11 -ffp-contract=off $profile"
warnings="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Werror"

is_up_to_date() {
    [ -f "$to/done" ] &&
        [ -z "$(find "$root/src" "$root/include" "$root/port" "$root/tests/target" \
            "$root/CMakeLists.txt" -type f \
            -newer "$to/done" | head -n 1)" ]
}

build() {
    rm -f "$to/done"
    touch "$to/begun"
    for file in $sources; do
        $compiler $options $flags $warnings $include -c "$root/src/$file" -o "$to/$file.o"
    done
    mv "$to/begun" "$to/done"
}

mkdir -p "$to"
exec 9>"$to/lock"
flock 9 # two tests may want it at the same time
is_up_to_date || build >&2
echo "$to"
