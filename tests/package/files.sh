#!/bin/sh
# files.sh WORK OBJECTS: the table of files in src/README.md, with the library's objects of the folder OBJECTS.  For each of its rows and each arithmetic, a program that
# refers to every function of the row's headers links with the row's files and with no others.
# Rows: | `header.h`, ... | `file_<T>.c`, ... |
# shellcheck disable=SC2016,SC2086
set -eu
work=$1 compiled=$2
root=$(cd "$(dirname "$0")/../.." && pwd)
rm -rf "$work"
mkdir -p "$work"

object() { # FILE: there has to be such a file
    [ -f "$root/src/$1" ] && echo "$compiled/$1.o"
}

# The functions of a header in one arithmetic
functions() { # HEADER T
    grep -v '^ *[*/]\|^typedef' "$root/include/kalmanq/$1" | grep -o "\bkq_[a-z_0-9]*_$2(" | tr -d '(' | sort -u
    [ "$1" = status.h ] && echo kq_status_text
    true
}

check() { # HEADERS T FILES
    {
        echo '#include "kalmanq/kalmanq.h"'
        echo 'typedef void function(void);'
        echo 'function *const all[] = {0'
        for header in $1; do
            for name in $(functions "$header" "$2"); do echo ", (function *)$name"; done
        done
        echo '}; int main(void) { return all[0] != 0; }'
    } >"$work/program.c"
    objects=
    for file in $3; do objects="$objects $(object "$file")"; done
    count=$(grep -c function "$work/program.c")
    [ "$count" -gt 2 ] || { echo "$1, $2: no functions"; return 1; }
    cc -std=c11 -w -I"$root/include" "$work/program.c" $objects -lm -o "$work/program"
    echo "$1, $2: $((count - 2)) functions with $3"
}

words() { echo "$1" | grep -o '`[^`]*`' | tr -d '`' | tr '\n' ' '; }

rows=0
grep '^| `[a-z_]*\.h`.* | `.*\.c`' "$root/src/README.md" >"$work/table"
while IFS='|' read -r _ headers files _; do
    headers=$(words "$headers") files=$(words "$files")
    case $files in
    *'<T>'*) arithmetics="f32 f64 q31" ;;
    *) arithmetics=q31 ;;
    esac
    case "$headers" in em.h* | sigma_points.h*) arithmetics="f32 f64" ;; esac
    for arithmetic in $arithmetics; do
        check "$headers" $arithmetic "$(echo "$files" | sed "s/<T>/$arithmetic/g")"
    done
    rows=$((rows + 1))
done <"$work/table"
echo "$rows rows"
[ "$rows" -ge 8 ]
