#!/bin/sh
# The unit tests of one arithmetic under clang's MemorySanitizer, which stops where a word that
# nobody wrote decides anything.  Library, Unity and tests are compiled here: all of a program has
# to be.
#
#     run_msan.sh CLANG SOURCE_DIR UNITY_DIR WORK_DIR ARITHMETIC TEST...
set -eu
clang=$1 source=$2 unity=$3 work=$4 arithmetic=$5
shift 5

compile() {
    "$clang" -std=c11 -O1 -g -ffp-contract=off -fsanitize=memory -fno-sanitize-recover=all \
        -DUNITY_INCLUDE_DOUBLE -DUNITY_DOUBLE_PRECISION=1e-12 \
        -I"$source/include" -I"$source/src" -isystem "$unity" "$@"
}

mkdir -p "$work"
for file in "$source"/src/*.c "$unity/unity.c"; do
    compile -c "$file" -o "$work/$(basename "$file" .c).o"
done
case $arithmetic in
f32) define=-DKQ_TEST_F32 suffix= ;;
f64) define=-DKQ_TEST_F64 suffix= ;;
*) define= suffix=_$arithmetic ;;
esac
failed=0
for name in "$@"; do
    compile $define "$source/tests/unit/test_$name$suffix.c" "$work"/*.o -lm -o "$work/$name"
    "$work/$name" >"$work/$name.log" 2>&1 && continue
    failed=1
    echo "$name:"
    grep -v ':PASS$' "$work/$name.log"
done
exit $failed
