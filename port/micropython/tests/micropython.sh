#!/usr/bin/env bash
# micropython.sh CORE WORK: the module of port/micropython, compiled into MicroPython's interpreter; CORE is host, or m4f
# under an emulator.  A script's filter has the bits that the same filter in C has on the host.
# The interpreter is 1.9.2, the one that Debian has the source of (setup.sh, group micropython).
set -euo pipefail
core=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
source="$root/.deps/micropython"
# shellcheck source=tests/target/cores.sh
. "$root/tests/target/cores.sh"
core_select "$core"
rm -rf "$work" && mkdir -p "$work/genhdr/qstr"

include=(-I"$here" -I"$work" -I"$source/inc" -I"$source/source" -I"$root/include")
module=("$root"/port/micropython/*.c)
python3 -c 'import sys; print(",".join(str(byte) for byte in open(sys.argv[1], "rb").read()))' "$here/try.py" >"$work/script.h"
cp "$source/inc/genhdr/mpversion.h" "$work/genhdr"

# micropython.cmake and micropython.mk name what there is to compile
builds() {
    mkdir "$work/cmake"
    printf '%s\n' 'cmake_minimum_required(VERSION 3.13)' 'project(usermod C)' 'add_library(usermod INTERFACE)' \
        "include($root/port/micropython/micropython.cmake)" 'add_library(firmware OBJECT empty.c)' \
        "target_include_directories(firmware PRIVATE $here $work $source/inc)" 'target_link_libraries(firmware PRIVATE usermod)' \
        >"$work/cmake/CMakeLists.txt"
    touch "$work/cmake/empty.c"
    cmake -S "$work/cmake" -B "$work/cmake/build" >/dev/null && cmake --build "$work/cmake/build" >/dev/null || return 1
    [ "$(find "$work/cmake/build" -name '*.c.o' | wc -l)" = 4 ] || return 1
    printf 'include %s/port/micropython/micropython.mk\nfiles: $(SRC_USERMOD)\n' "$root" |
        make -s -f - "USERMOD_DIR=$root/port/micropython" files
}

# The names that MP_QSTR_... stand for, as MicroPython's build collects them
$compiler -E -DNO_QSTR "${include[@]}" "$source"/source/py/*.c "$here/main.c" "$root/port/micropython/kalmanq_module.c" >"$work/names.i"
(cd "$work" && python3 "$source/source/py/makeqstrdefs.py" split names.i genhdr/qstr genhdr/collected.h &&
    python3 "$source/source/py/makeqstrdefs.py" cat names.i genhdr/qstr genhdr/collected.h) >/dev/null
cat "$source/inc/py/qstrdefs.h" "$work/genhdr/collected.h" | sed 's/^Q(.*)/"&"/' | $compiler -E "${include[@]}" - |
    sed 's/^"\(Q(.*)\)"/\1/' >"$work/genhdr/preprocessed.h"
python3 "$source/source/py/makeqstrdata.py" "$work/genhdr/preprocessed.h" >"$work/genhdr/qstrdefs.generated.h"

# shellcheck disable=SC2086
{
    (cd "$work" && $compiler -std=gnu11 -Os -w -ffunction-sections -fdata-sections "${include[@]}" -c "$source"/source/py/*.c "$here/main.c")
    warnings="-Wall -Wextra -Wno-unused-parameter -Wdouble-promotion -Wpointer-arith -Werror -isystem $source/inc"
    flags=$(sed -n 's/^CFLAGS_USERMOD += -I[^ ]* //p' "$root/port/micropython/micropython.mk")
    (cd "$work" && $compiler -std=gnu99 -ffunction-sections -fdata-sections -Os $flags $warnings -I"$here" -I"$work" -I"$root/include" -c "${module[@]}")
    $linker -Wl,--gc-sections "$work"/*.o -lm -o "$work/interpreter"
}
# shellcheck disable=SC2086
timeout "${KQ_TIME_LIMIT:-600}" $emulator "$work/interpreter" >"$work/said.txt" || { cat "$work/said.txt" && exit 1; }
cat "$work/said.txt"
cc -std=c11 -O2 -fno-math-errno -ffp-contract=off -I"$root/include" "$here/reference.c" "$root/src/kq_filter_f32.c" \
    "$root/src/kq_status.c" -lm -o "$work/reference"
[ "$("$work/reference")" = "$(head -1 "$work/said.txt")" ] || { echo "in C: $("$work/reference")" && exit 1; }

# What the module takes of flash: the program without it
echo '#include "py/obj.h"
const mp_obj_module_t kalmanq_module = {.base = {&mp_type_module}, .globals = 0};' >"$work/without.c"
# shellcheck disable=SC2086
(cd "$work" && $compiler -std=gnu11 -w "${include[@]}" -c without.c && mv kalmanq_module.o kalmanq_module.kept &&
    $linker -Wl,--gc-sections ./*.o -lm -o without)
text_of() { ${compiler%%gcc*}size "$1" | awk 'NR == 2 { print $1 + $2 }'; }
echo "flash of the module and its library: $(($(text_of "$work/interpreter") - $(text_of "$work/without"))) bytes"
[ "$core" != host ] || builds || { echo "micropython.cmake or micropython.mk does not build" && exit 1; }
[ "$(tail -1 "$work/said.txt")" = done ]
