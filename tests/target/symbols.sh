#!/bin/sh
# symbols.sh BUILD CORE COMPILER: the library's objects in the directory BUILD refer to nothing that does
# not belong there, and have no data that is written.
# shellcheck disable=SC2086
set -eu
build=$1 name=$2
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/target/cores.sh"
core_select "$name" "$3"
# What an object may ask for: memory moves that compilers insert; in float, soft-float single
# precision where there is no FPU; in fixed point, integer helpers.  Nothing of double, of the
# heap, of stdio, no assert; on hardware floating point the root is an instruction.
memory='^(mem(cpy|move|set)|__aeabi_mem.*)$'
floats='^$'
case $core in
rv32 | avr)
    integers='^__(clzsi2|(u?mulsi|ashl|ashr|lshr)di3)$'
    floats='^(__((add|sub|mul|div)sf3|(eq|ne|lt|le|gt|ge)sf2|fix(uns)?sfsi|float(un)?sisf)|sqrtf)$'
    ;;
*)
    integers='^(__aeabi_(lmul|llsl|llsr|lasr|u?idiv(mod)?|u?lcmp)|__clzsi2)$'
    ;;
esac
case $core in
m0 | m3) # lmul: lengths are counted in 64 bits
    floats='^(__aeabi_(f(add|sub|mul|div|cmp(eq|lt|le|ge|gt|un)|2u?iz)|u?i2f|u?idiv(mod)?|lmul)|sqrtf)$'
    ;;
avr) # 8 bits: arithmetic of 32 and 64 bits, too; and the start-up is to copy constants into RAM
    more='__((mul|add|sub|neg|cmp)di[23](_s8)?|mulsi3|(us?)?mulhisi3|mul[ou]hisi3|u?divmod[hs]i4'
    more="$more|do_(copy_data|clear_bss))$"
    integers="$integers|^$more|^__(prologue_saves|epilogue_restores)__$"
    # lengths are counted in 64 bits
    floats="$floats|^__((mul|add|sub|neg|cmp)di[23](_s8)?|(ashl|ashr|lshr)di3|u?mulsidi3"
    floats="$floats|mulsi3|(us?)?mulhisi3|mul[ou]hisi3|u?divmod[hs]i4|do_(copy_data|clear_bss)|prologue_saves__"
    floats="$floats|epilogue_restores__)$"
    ;;
esac

check_object() { # name, what it may refer to
    object=$build/$1.c.o
    refers=$($nm -u "$object" | awk '{print $NF}')
    foreign=$(echo "$refers" | grep -Ev "$memory|$2|^$" || true)
    if [ -n "$foreign" ]; then
        echo "$name: $1 refers to:" $foreign
        exit 1
    fi
    echo "$name: $1 refers to:" $refers
    [ "$core" = avr ] || # constants are in RAM there
        ! $nm "$object" | grep -E ' [BbDdC] ' || { echo "$name: $1 has writable data"; exit 1; }
}

check_object kq_filter_q31 "$integers"
settling="predict|update_subset|step|gain|history_assign" # and the smoother's, on a history of its own
check_object kq_steady_f32 "$floats|^kq_($settling|filter_assign)_f32$"
check_object kq_steady_q31 "$integers|^kq_($settling)_q31$"
check_object kq_range_error_q31 "$integers"
check_object kq_statistics_q31 "$integers|^kq_(update|sensor_init)_q31$"
check_object kq_adaptation_q31 "$integers|^kq_(predict|update|update_subset|sensor_independent)_q31$"
check_object kq_self_test_q31 "$integers|^kq_((process|sensor|filter)_init|filter_assign|step|log_likelihood)_q31$"
case $sources in
*kq_filter_f32*)
    self_test='^kq_((process|sensor|filter)_(init|assign)|sensor_init_diagonal)_f32$'
    self_test="$self_test|^kq_(predict|update|mean|mean_low|log_likelihood)_f32$"
    check_object kq_self_test_f32 "$floats|$self_test"
    check_object kq_filter_f32 "$floats"
    check_object kq_statistics_f32 "$floats|^kq_(update|sensor_assign|sensor_independent)_f32$"
    check_object kq_adaptation_f32 "$floats|^kq_(predict|update|update_subset|sensor_independent)_f32$"
    points="predict_(extended|check|end)|update_(check|by_rows)|root_of_rows|sensor_(correlated|independent|correlated_extended)"
    points="$points|process_change_transition|sensor_change_measurement"
    check_object kq_nonlinear_f32 "$floats|^kq_($points)_f32$"
    em="predict|update_subset|sensor_(independent|correlated)|(filter|process|sensor|history)_assign"
    check_object kq_em_f32 "$floats|^kq_($em|attach)_f32$"
    ;;
esac
echo "$name: clean"
