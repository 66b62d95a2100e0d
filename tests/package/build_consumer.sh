#!/bin/sh
# build_consumer.sh WAY SOURCE CONSUMER WORK BUILD: builds and runs the consumer program one way.  BUILD has the library
# built, which is installed where a way needs that.
set -eu
way=$1 source=$2 consumer=$3 work=$4 build=$5
rm -rf "$work"
mkdir -p "$work"

install_library() {
    cmake --install "$build" --prefix "$work/prefix"
}

case $way in
pkg_config)
    install_library
    PKG_CONFIG_PATH="$work/prefix/lib/pkgconfig"
    export PKG_CONFIG_PATH
    # shellcheck disable=SC2046
    cc -std=c11 "$consumer/main.c" $(pkg-config --cflags --libs kalmanq) -o "$work/consumer"
    # shellcheck disable=SC2046
    cc -std=c11 -O2 "$consumer/fixed_size.c" $(pkg-config --cflags --libs kalmanq) \
        -o "$work/fixed_size"
    "$work/fixed_size"
    ;;
top_level) # the first thing one tries, on a machine that has a C compiler and no network
    cmake -S "$source" -B "$work/library" -DKALMANQ_UNITY_DIR="$work/none" -DCMAKE_BUILD_TYPE=Debug \
        -DFETCHCONTENT_FULLY_DISCONNECTED=ON |
        tee "$work/configure.txt"
    grep -q 'tests are left out, for want of Unity; tools/test.sh' "$work/configure.txt"
    cmake --build "$work/library"
    cc -std=c11 -I"$source/include" "$consumer/main.c" "$work/library/libkalmanq.a" -lm \
        -o "$work/consumer"
    ;;
plain)
    cc -std=c11 -O2 -I"$source/include" "$consumer/main.c" "$source"/src/*.c -lm \
        -o "$work/consumer"
    # the few files and flags that the README names
    row=$(grep '^| anything else' "$source/README.md")
    files=$(echo "$row" | grep -o 'src/kq_[a-z0-9_]*[.]c')
    flags=$(echo "$row" | grep -o -- '[ `]-[IOf][^ `]*' | tr -d '`')
    # shellcheck disable=SC2086
    (cd "$source" && cc $flags tests/package/first.c $files -Wl,--gc-sections -lm -o "$work/first")
    [ "$("$work/first")" = "511.19 +- 0.90" ]
    ;;
*)
    [ "$way" = find_package ] && install_library
    cmake -S "$consumer" -B "$work/build" -DWAY="$way" -DKALMANQ_SOURCE="$source" \
        -DCMAKE_PREFIX_PATH="$work/prefix" -DFETCHCONTENT_FULLY_DISCONNECTED=ON
    cmake --build "$work/build"
    cp "$work/build/consumer" "$work/consumer"
    ;;
esac
"$work/consumer"
