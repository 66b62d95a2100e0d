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
    configure "$source" CMakeFiles -DKALMANQ_BUILD_TESTS=OFF "$@"
    check "$@"
}

# of the library as a part of a project of these languages, which says no more than that
expect_within() { # WANTED LANGUAGES OPTION...
    wanted=$1
    mkdir -p "$work/user"
    printf '%s\n' 'cmake_minimum_required(VERSION 3.22)' "project(user $2)" "add_subdirectory($source kalmanq)" \
        'add_executable(user user.cpp)' 'target_link_libraries(user PRIVATE kalmanq::kalmanq)' >"$work/user/CMakeLists.txt"
    printf '%s\n' '#include <kalmanq/kalmanq.h>' 'int main() { return kq_length_f32(KQ_OBJECT_FILTER, 2, 0, 0, 0) == 0; }' >"$work/user/user.cpp"
    shift 2
    configure "$work/user" kalmanq/CMakeFiles "$@"
    check "part of a project" "$@"
}

configure() { # SOURCE FOLDER OPTION...
    flags=$work/library/$2/kalmanq.dir/flags.make
    rm -rf "$work/library"
    from=$1
    shift 2
    cmake -S "$from" -B "$work/library" -G "Unix Makefiles" "$@" >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
}

check() { # WHAT...
    found=$(level "$flags")
    echo "$*: ${found:-no level}"
    [ "$found" = "$wanted" ] || { echo "  it has to be ${wanted:-none}" && failed=1; }
}

expect_within O2 CXX
expect_within O1 "C CXX" "-DCMAKE_C_FLAGS=-O1"
expect_within Os "C CXX" -DCMAKE_BUILD_TYPE=MinSizeRel
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
