#!/bin/sh
# levels.sh SOURCE WORK: what the library is compiled with.  Release is -O2, as all figures are; what a user asks for
# otherwise holds.
set -eu
source=$1 work=$2
rm -rf "$work"
mkdir -p "$work"
failed=0

level() { # of the last -O, which counts
    tr ' ' '\n' <"$1" | sed -n 's/^-O/O/p' | tail -1
}

expect() { # WANTED OPTION...
    wanted=$1
    shift
    rm -rf "$work/library"
    cmake -S "$source" -B "$work/library" -G "Unix Makefiles" -DKALMANQ_BUILD_TESTS=OFF "$@" >"$work/log" ||
        { cat "$work/log" && exit 1; }
    flags=$work/library/CMakeFiles/kalmanq.dir/flags.make
    found=$(level "$flags")
    echo "$*: ${found:-no level}"
    [ "$found" = "$wanted" ] || { echo "  it has to be ${wanted:-none}" && failed=1; }
}

arm="-DCMAKE_TOOLCHAIN_FILE=$source/port/arm-none-eabi.cmake"
expect O2 # as it is where nothing is said
expect O2 -DCMAKE_BUILD_TYPE=Release
expect Os -DCMAKE_BUILD_TYPE=MinSizeRel
expect O2 -DCMAKE_BUILD_TYPE=RelWithDebInfo
expect "" -DCMAKE_BUILD_TYPE=Debug
expect O1 -DCMAKE_BUILD_TYPE=Release "-DCMAKE_C_FLAGS_RELEASE=-O1 -DNDEBUG"
expect O3 -DCMAKE_BUILD_TYPE=Release "-DCMAKE_C_FLAGS_RELEASE=-O3"
if command -v arm-none-eabi-gcc >/dev/null; then
    expect O2 "$arm" "-DCMAKE_C_FLAGS=-mthumb -mcpu=cortex-m0" -DCMAKE_BUILD_TYPE=Release
    expect Os "$arm" "-DCMAKE_C_FLAGS=-mthumb -mcpu=cortex-m0" -DCMAKE_BUILD_TYPE=MinSizeRel
fi
exit $failed
