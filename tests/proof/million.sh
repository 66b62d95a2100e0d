#!/bin/sh
# million.sh WORK [CORE]: the golden vector `velocity` ends with a run of 2000 steps whose measurements are drawn: it goes on for
# 1,000,000 more in q31, a hundred runs: the host records digests of what every step answers, and the emulated core, m0, has to come to the same.
# shellcheck disable=SC2086
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
vectors=$root/tests/vectors work=$1
. "$root/tests/target/cores.sh"
mkdir -p "$work/cases"
runs=$(seq 100 | sed 's/.*/17, 5,0,0,10000,&,14, 0,/' | tr '\n' ' ')
sed "s/17, 5,0,0,2000,777,14, [-0-9]*,/& $runs/" "$vectors/cases/velocity.inc" >"$work/asked.inc"
! cmp -s "$work/asked.inc" "$vectors/cases/velocity.inc" || { echo "velocity.inc has no such run any more" && exit 1; }

objects() { # of the library and the replay, on the core that is selected
    for file in $sources; do
        case $file in kq_prepare_q31.c | kq_self_test_q31.c) ;; kq_status.c | *_q31.c)
            $compiler $include $profile -std=c11 -O2 -c "$root/src/$file" -o "$work/$core-$file.o" && echo "$work/$core-$file.o" ;;
        esac
    done
    for file in "$@"; do
        $compiler $include "-I$work" -std=c11 -O2 -DVECTOR_Q31 -DVECTOR_CASE=million -c "$vectors/$file.c" -o "$work/$core-$file.o"
        echo "$work/$core-$file.o"
    done
}

core_select host
gcc -std=c11 -O2 -DVECTOR_Q31 "-I$root/include" "$vectors/record.c" "$vectors/vector.c" "$vectors/q31.c" "$root"/src/*.c -lm -o "$work/record"
"$work/record" <"$work/asked.inc" >"$work/cases/million.inc"
core_select "${2:-m0}"
$linker $(objects replay vector q31 one_case) $libraries -o "$work/million.$core"
sh "$root/tests/target/run.sh" "$core" "$work/million.$core"
