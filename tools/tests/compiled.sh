#!/usr/bin/env bash
# compiled.sh TOOLS_PYTHON PYTHON WORK [few]: five models compiled in f32 and q31; few: two, at -O2.  On the emulated cores each does what it did
# on the host (so do nonlinear models, two of them every day), with gcc at -Os and -O2 and on one with clang, and costs no more than it may.
set -euo pipefail
tools_python=$1 python=$2 work=$3 which=${4:-all}
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
rm -rf "$work"
mkdir -p "$work"
"$tools_python" -B "$here/compiled_table.py" "$work/filters" "$which"
cc -O2 "$root/port/boards/avr_emulator.c" -lsimavr -o "$work/avr_emulator"
export KQ_AVR_EMULATOR="$work/avr_emulator" KQ_TIME_LIMIT=60
. "$root/tests/target/cores.sh"

strict="-std=c11 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror"
tried() { # COMPILER: $name of $folder on $core
    for file in "$name" "${name}_test"; do
        warned=$strict
        case $core:$name in # its math.h has cos in the place of cosf; a double is a float there
            avr:equations_*) warned=${strict/-Wdouble-promotion/} ;;
        esac
        # shellcheck disable=SC2086
        $1 $warned -$level -ffp-contract=$contract -c "$folder/$file.c" -o "$work/$file.o"
    done
    # shellcheck disable=SC2086
    $linker "$work/$name.o" "$work/${name}_test.o" $libraries -o "$work/$name.$core"
    sh "$root/tests/target/run.sh" "$core" "$work/$name.$core" >"$work/log" || { cat "$work/log"; exit 1; }
}

same_digest() { # its test prints the digest that its comment has, where products are not fused
    [ $contract = off ] || { contract=off && tried "$gcc"; } # otherwise it has just run
    digest=$(sed -n 's/.*ffp-contract=off).*: \([0-9a-f]*\)[.].*/\1/p' "$folder/${name}_test.c")
    grep -q "digest $digest\$" "$work/log" || { echo "$name on $core: not the digest $digest"; cat "$work/log"; exit 1; }
}

for folder in "$work"/filters/*; do
    name=$(basename "$folder") && name=${name%_*}
    for core in m0 m3 m4f m33 rv32 avr; do
        case $core:$name in # what fits its memory
            avr:linear_m21 | avr:linear_m31 | avr:linear_lag | avr:linear_every | avr:linear_student | avr:linear_loops | avr:linear_late) ;;
            avr:exact_glucose | avr:equations_unicycle | avr:equations_tank | avr:equations_cell) ;;
            avr:*) continue ;;
        esac
        core_select "$core"
        case $core in m4f | m33) contract=fast ;; *) contract=off ;; esac
        for level in $([ "$which" = few ] || echo Os) O2; do
            tried "$gcc"
        done
        case $name in linear_* | exact_*) same_digest ;; esac
        echo "$(basename "$folder") on $core: as on the host"
    done
    if [ "$which" != few ] && command -v clang >/dev/null; then
        # shellcheck disable=SC2086
        clang $strict -O2 -c "$folder/$name.c" -o "$work/clang.o"
        core_select m3 clang && contract=off level=O2
        tried "$compiler"
        echo "$(basename "$folder") on $core by clang: as on the host"
    fi
done
"$python" -B "$here/compiled_costs.py" "$work"/filters/*_f32 --core m4f --level O2 $([ "$which" = few ] || echo --level Os)
"$python" -B "$here/compiled_costs.py" "$work"/filters/*_q31 --core m3 $([ "$which" = few ] || echo --core m0)
echo "all compiled filters are as on the host"
