#!/bin/sh
# The one place that knows the cores: compilers and their flags, C libraries, boards, emulators.
#
#   cores.sh describe CORE [COMPILER]    prints all that is below, a line "name=value" for each
#   cores.sh names                       the cores, as CORE
#
# Or sourced, with $root set to the source tree:
#
#   core_select CORE [COMPILER]    CORE: host, m0, m3, m4f, m7, m33, rv32, avr; two small parts, with
#                                  their memory and nothing beside it: m0-4k (32 kB of flash, 4 kB
#                                  of RAM), atmega328p; atmega1284p, its large sister
#                                  COMPILER: gcc (if none is given), clang
#   $compiler $include -c FILE     compiles;  $nm lists symbols
#   $linker OBJECT... $libraries -o PROGRAM    links, with the board's start-up and memory
#   $emulator PROGRAM              runs it (better: run.sh)
#   $gcc                           the gcc whose C library and linker are used
#   $sources                       the library's files, without src/: all of them, on every core
#   $floating                      the arithmetics in floating point that the core has
#   $profile                       the flags that the library is built with, as CMakeLists.txt has them
#   $user_profile                  those for functions of compile-time sizes, in a user's own files
#   $port                          the folder of port/ that is the core's, if there is one
#
# CORE+port, as m3+port, puts the headers of the core's own port before the portable ones, and
# leaves out the float sources, which do not include them.  clang
# takes the C library and the linker of gcc.
# shellcheck shell=sh disable=SC2034,SC2086

core_unknown() {
    echo "cores.sh: what is $1?" >&2
    exit 1
}

core_flags() { # of a list in CMakeLists.txt
    sed -n "s/^set($1 \([^)]*\)).*/\1/p" "$root/CMakeLists.txt"
}

core_select() {
    core=${1%+port} boards="$root/port/boards" port="" libraries=-lm
    sources=$(cd "$root/src" && echo *.c) floating="f32 f64"
    profile=$(core_flags KALMANQ_PROFILE)
    case $core in
    host) ;;
    m0 | m0-4k) machine="-mcpu=cortex-m0" triple=thumbv6m-none-eabi board=mps2-an385 port=armv6m ;;
    m3) machine="-mcpu=cortex-m3" triple=thumbv7m-none-eabi board=mps2-an385 port=armv7m ;;
    m4f)
        machine="-mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16"
        triple=thumbv7em-none-eabi board=mps2-an386 port=armv7m
        ;;
    m7)
        machine="-mcpu=cortex-m7 -mfloat-abi=hard -mfpu=fpv5-d16"
        triple=thumbv7em-none-eabi board=mps2-an500 port=armv7m
        ;;
    m33)
        machine="-mcpu=cortex-m33 -mfloat-abi=hard -mfpu=fpv5-sp-d16"
        triple=thumbv8m.main-none-eabi board=mps2-an505 port=armv7m
        ;;
    rv32) machine="-march=rv32imac -mabi=ilp32" triple=riscv32-unknown-elf ;;
    avr) machine="-mmcu=atmega2560" triple=avr port=avr ;;
    atmega328p | atmega1284p) machine="-mmcu=$core" triple=avr port=avr ;;
    *) core_unknown "core $1" ;;
    esac
    case $core in
    host) core_is_host ;;
    m*) core_is_cortex_m ;;
    rv32) core_is_riscv ;;
    avr | atmega*) core_is_avr ;;
    esac
    user_profile=$profile
    case ${2:-gcc} in
    gcc)
        compiler=$gcc
        user_profile="$profile $(core_flags KALMANQ_PROFILE_GNU)"
        profile="$user_profile $(core_flags KALMANQ_PROFILE_COMPACT)"
        ;;
    clang) core_takes_clang ;;
    *) core_unknown "compiler $2" ;;
    esac
    include="-I$root/include"
    case $1 in
    *+port)
        { [ -n "$port" ] && [ -d "$root/port/$port" ]; } || core_unknown "port/$port"
        include="-I$root/port/$port $include"
        floating=
        sources=$(echo "$sources" | sed 's/[a-z_]*_f[36][24][.]c *//g')
        ;;
    esac
}

core_is_host() {
    # constants that hold addresses are no writable data where code does not move
    gcc="gcc -fno-pie" linker="gcc -no-pie" nm=nm emulator="" machine=-fno-pie
}

core_is_cortex_m() {
    memory=$boards/mps2.ld
    [ $core = m33 ] && memory=$boards/mps2_secure.ld
    gcc="arm-none-eabi-gcc -mthumb $machine"
    linker="$gcc --specs=rdimon.specs -nostartfiles -Wl,-z,noexecstack"
    linker="$linker -L $boards -T $memory $boards/cortex_m.c"
    if [ $core = m0-4k ]; then
        linker="$gcc -nostdlib -Wl,--gc-sections -L $boards -T $boards/m0_4k.ld $boards/m0_4k.c"
        libraries="-lc -lgcc"
    fi
    nm=arm-none-eabi-nm
    emulator="qemu-system-arm -M $board -nographic -semihosting -kernel"
}

# The C library is picolibc, with its start-up and its semihosting
core_is_riscv() {
    gcc="riscv64-unknown-elf-gcc --specs=picolibc.specs $machine"
    linker="$gcc --crt0=semihost --oslib=semihost -T $boards/riscv_virt.ld"
    nm=riscv64-unknown-elf-nm
    emulator="qemu-system-riscv32 -M virt -bios none -nographic -semihosting -kernel"
}

# avr_emulator is built with the tests; KQ_AVR_EMULATOR says where it is.
core_is_avr() {
    gcc="avr-gcc $machine"
    memory="-Wl,--defsym=__DATA_REGION_LENGTH__=0xFFA0,--section-start,.data=0x802200"
    emulator=${KQ_AVR_EMULATOR:-avr_emulator}
    if [ $core = atmega328p ]; then
        memory="-Wl,--defsym=__TEXT_REGION_LENGTH__=32K,--defsym=__DATA_REGION_LENGTH__=2K"
        emulator="$emulator --part"
    fi
    linker="$gcc -mrelax -Wl,--gc-sections $memory $boards/avr.c"
    floating=f32 # a double has 32 bits in avr-gcc 5
    profile="$profile $(core_flags KALMANQ_PROFILE_AVR)"
    nm=avr-nm
}

core_takes_clang() {
    clang=$(command -v clang || command -v clang-14 || echo clang)
    if [ $core = host ]; then
        compiler="$clang $machine" linker="$clang -no-pie"
        return
    fi
    header=$(echo '#include <stdio.h>' | $gcc -E -M - 2>/dev/null | tr ' ' '\n' | grep -m 1 '/stdio\.h$')
    compiler="$clang --target=$triple $machine -isystem $(dirname "$header")"
    case $core in
    m*) compiler="$compiler -fshort-enums" ;; # as gcc
    rv32) compiler="$compiler -ftls-model=local-exec" ;; # as picolibc
    esac
}

core_describe() { # CORE [COMPILER]
    core_select "$@"
    cat <<END
core=$core
compiler=$compiler
gcc=$gcc
nm=$nm
linker=$linker
libraries=$libraries
emulator=$emulator
include=$include
port=$port
sources=$sources
floating=$floating
profile=$profile
user_profile=$user_profile
END
}

if [ "${0##*/}" = cores.sh ]; then
    root=$(cd "$(dirname "$0")/../.." && pwd)
    case ${1:-} in
    describe)
        shift
        core_describe "$@"
        ;;
    names) echo host m0 m3 m4f m7 m33 rv32 avr m0-4k atmega328p atmega1284p ;;
    *) core_unknown "${1:-wanted: describe, names}" ;;
    esac
fi
