#!/bin/sh
# cxx.sh INCLUDE LIBRARY WORK: every header by itself, and cxx.cpp, under g++ and clang++, from C++11 to C++23; a status
# that is dropped is a warning, of functions with and without a suffix; a file of the library as C++ is one error, which says so.
# shellcheck disable=SC2086
set -eu
here=$(cd "$(dirname "$0")" && pwd)
include=$1 library=$2 work=$3
flags="-Wall -Wextra -Wpedantic -Wconversion -Wold-style-cast -Werror -I$include -x c++"
mkdir -p "$work"

dropped() { # COMPILER STANDARD CALL: nothing but a warning of the dropped status
    printf '#include <kalmanq/kalmanq.h>\n#include <kalmanq/generic.h>\nvoid drop(kq_filter_f32 *f) { %s; }\n' "$3" |
        $1 -std=c++$2 $flags -c -o /dev/null - 2>"$work/said" &&
        echo "$1, C++$2: nobody says that the status of $3 is dropped" && exit 1
    [ "$(grep -c 'error:' "$work/said")" = 1 ] && grep -q 'unused-result\|nodiscard' "$work/said"
}

if grep -n '^kq_status kq_' "$include"/kalmanq/*.h; then echo "KQ_NODISCARD is missing" && exit 1; fi
for compiler in g++ clang++; do
    command -v $compiler >/dev/null || { echo "$compiler is not installed" && exit 1; }
    for source in filter_f32 em_f64 filter_q31 prepare_q31; do
        $compiler -x c++ "-I$include" -c "$include/../src/kq_$source.c" -o /dev/null 2>"$work/said" && echo "kq_$source.c is no C++" && exit 1
        [ "$(grep -c 'error:' "$work/said")" = 1 ] && grep -q compile_this_file_as_C "$work/said"
    done
    for standard in 11 14 17 20 2b; do
        for header in "$include"/kalmanq/*.h; do
            echo "#include <kalmanq/${header##*/}>" | $compiler -std=c++$standard $flags -fsyntax-only -
        done
        dropped $compiler $standard 'kq_predict_f32(f, nullptr, nullptr)'
        dropped $compiler $standard 'kq_predict(f, nullptr, nullptr)'
        $compiler -std=c++$standard $flags "$here/cxx.cpp" -x none "$library" -lm -o "$work/program"
        "$work/program"
    done
done
echo "headers are clean in C++"
