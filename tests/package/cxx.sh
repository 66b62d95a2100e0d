#!/bin/sh
# cxx.sh INCLUDE: every header by itself under g++ and clang++, from C++11 to C++23, and a status that is dropped.
set -eu
flags="-Wall -Wextra -Wpedantic -Wconversion -Wold-style-cast -Werror -I$1 -x c++ -fsyntax-only"
for compiler in g++ clang++; do
    command -v $compiler >/dev/null || { echo "$compiler is not installed" && exit 1; }
    for standard in 11 14 17 20 2b; do
        for header in "$1"/kalmanq/*.h; do
            name=${header##*/}
            [ "$name" = generic.h ] && continue # of C alone
            # shellcheck disable=SC2086
            echo "#include <kalmanq/$name>" | $compiler -std=c++$standard $flags -
        done
        # shellcheck disable=SC2086
        if printf '#include <kalmanq/kalmanq.h>\nvoid drop(kq_filter_f32 *f) { kq_predict_f32(f, nullptr, nullptr); }\n' |
            $compiler -std=c++$standard ${flags% -fsyntax-only} -c -o /dev/null - 2>"${TMPDIR:-/tmp}/cxx.$$"; then
            echo "$compiler, C++$standard: nobody says that a status is dropped" && exit 1
        fi
        grep -q 'unused-result\|nodiscard' "${TMPDIR:-/tmp}/cxx.$$"
        rm "${TMPDIR:-/tmp}/cxx.$$"
    done
done
echo "headers are clean in C++"
