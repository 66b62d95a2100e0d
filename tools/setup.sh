# Installs what a fresh Debian or Ubuntu machine lacks.  Sourced by demo.sh and test.sh.
#
#   kq_setup build     C and C++ compiler, CMake, Ninja
#   kq_setup python    sets KQ_PYTHON to an interpreter with the demo's libraries
#   kq_setup tests     Eigen, Unity, clang, pkg-config, and compilers and emulators for Arm, RISC-V
#                      and AVR; KQ_PYTHON with SciPy, too; sets KQ_PEERS_PYTHON to an
#                      interpreter with the libraries that results are compared with
#   kq_setup cost      compilers for Arm, RISC-V and AVR, their emulators; KQ_PYTHON with these, too
#
# Nothing that is there is installed again, and nothing is asked of the network then.

kq_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
kq_unity="$kq_root/.deps/unity"

kq_as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

# kq_install PACKAGE...: by apt, those that are missing
kq_install() {
    local missing=() package
    for package in "$@"; do
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
            missing+=("$package")
    done
    [ ${#missing[@]} -eq 0 ] && return 0
    command -v apt-get >/dev/null || {
        echo "setup: please install (no apt here): ${missing[*]}" >&2
        return 1
    }
    echo "setup: installing ${missing[*]}"
    kq_as_root apt-get update -qq
    kq_as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

kq_have() {
    local tool
    for tool in "$@"; do command -v "$tool" >/dev/null || return 1; done
}

kq_setup_build() {
    kq_have cc c++ cmake ninja || kq_install gcc g++ libc6-dev cmake ninja-build
}

# kq_find_python MODULE...: sets KQ_PYTHON to the first interpreter that has them all
kq_find_python() {
    local python modules
    modules="import $(IFS=, && echo "$*")"
    for python in "${KQ_PYTHON:-}" python3 /usr/bin/python3; do
        [ -n "$python" ] && "$python" -c "$modules" 2>/dev/null && KQ_PYTHON=$python && return 0
    done
    return 1
}

kq_setup_python() {
    kq_find_python numpy matplotlib typer rich && return 0
    kq_install python3 python3-numpy python3-matplotlib python3-typer python3-rich
    KQ_PYTHON=/usr/bin/python3
}

# Unity is not packaged by itself; the source package of cjson carries it.  The source lists
# are a copy with deb-src switched on: the machine's own stay as they are.
kq_fetch_unity() {
    local work lists
    work=$(mktemp -d) && lists="$work/lists" && mkdir -p "$lists/parts" "$lists/state/partial"
    cp /etc/apt/sources.list "$lists/list" 2>/dev/null || : >"$lists/list"
    cp /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list.d/ubuntu.sources \
        "$lists/parts/" 2>/dev/null || true
    sed -i 's/^Types:.*/Types: deb deb-src/' "$lists"/parts/*.sources 2>/dev/null || true
    sed -i -n 'p; s/^deb /deb-src /p' "$lists/list"
    (
        cd "$work"
        options=(-o Dir::Etc::sourcelist="$lists/list" -o Dir::Etc::sourceparts="$lists/parts"
                 -o Dir::State::Lists="$lists/state" -o Dir::Cache::pkgcache=
                 -o Dir::Cache::srcpkgcache= -o APT::Sandbox::User=root)
        apt-get "${options[@]}" update -qq &&
            apt-get "${options[@]}" source -qq --download-only cjson >/dev/null &&
            tar -xf cjson_*.orig.tar.*
    ) || { rm -rf "$work"; return 1; }
    mkdir -p "$kq_unity"
    cp -r "$work"/cJSON-*/tests/unity/. "$kq_unity/"
    rm -rf "$work"
}

# A file of a C library, which the compiler finds: kq_have_file COMPILER FILE
kq_have_file() { "$1" -print-file-name="$2" | grep -q /; }

kq_setup_targets() {
    kq_have arm-none-eabi-gcc qemu-system-arm && kq_have_file arm-none-eabi-gcc rdimon.specs ||
        kq_install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm
    kq_have riscv64-unknown-elf-gcc qemu-system-riscv32 &&
        kq_have_file riscv64-unknown-elf-gcc picolibc.specs ||
        kq_install gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf qemu-system-misc
    kq_have avr-gcc && kq_have_file avr-gcc libc.a &&
        echo '#include <simavr/sim_avr.h>' | cc -E - >/dev/null 2>&1 ||
        kq_install gcc-avr avr-libc libsimavr-dev
}

# The runtime of clang's MemorySanitizer, which Debian has in a package of its own
kq_setup_sanitizer() {
    kq_have clang || return 1
    [ -n "$(find "$(clang -print-resource-dir)/lib" -name 'libclang_rt.msan*.a' 2>/dev/null)" ] ||
        kq_install "libclang-rt-$(clang -dumpversion | cut -d. -f1)-dev"
}

kq_setup_tests() {
    kq_install libeigen3-dev pkg-config
    kq_have clang || kq_have clang-14 || kq_install clang
    kq_setup_sanitizer || echo "setup: clang has no MemorySanitizer here; its tests are left out"
    kq_setup_targets
    kq_have valgrind || kq_install valgrind
    kq_setup_peers
    [ -f "$kq_unity/src/unity.c" ] || kq_fetch_unity ||
        echo "setup: no source package with Unity; CMake fetches its pinned release"
    kq_find_python numpy scipy matplotlib typer rich unicorn elftools && return 0
    kq_install python3 python3-numpy python3-scipy python3-matplotlib python3-typer python3-rich \
        python3-unicorn python3-pyelftools
    KQ_PYTHON=/usr/bin/python3
}

# Kalman libraries that results are compared with are not packaged: a virtual environment of its own,
# from PyPI.  Sets KQ_PEERS_PYTHON.
kq_setup_peers() {
    KQ_PEERS_PYTHON="$kq_root/.deps/python/bin/python"
    "$KQ_PEERS_PYTHON" -c 'import numpy, statsmodels, pykalman' 2>/dev/null && return 0
    python3 -c 'import ensurepip, venv' 2>/dev/null || kq_install python3 python3-venv
    echo "setup: installing statsmodels and pykalman"
    python3 -m venv "$kq_root/.deps/python" &&
        "$KQ_PEERS_PYTHON" -m pip install -q --disable-pip-version-check \
            statsmodels==0.15.0 pykalman==0.11.2
}

kq_setup_cost() {
    kq_setup_build
    kq_have arm-none-eabi-gcc && arm-none-eabi-gcc -print-file-name=nano.specs | grep -q / ||
        kq_install gcc-arm-none-eabi libnewlib-arm-none-eabi
    kq_install gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf gcc-avr avr-libc libsimavr-dev
    kq_have clang || kq_have clang-14 || kq_install clang
    kq_find_python numpy matplotlib typer rich unicorn elftools && return 0
    kq_install python3 python3-numpy python3-matplotlib python3-typer python3-rich \
        python3-unicorn python3-pyelftools
    KQ_PYTHON=/usr/bin/python3
}

kq_setup() { "kq_setup_$1"; }

# kq_quietly COMMAND...: what it prints is shown only if it fails
kq_quietly() {
    local log status=0
    log=$(mktemp)
    "$@" >"$log" 2>&1 || { status=$? && cat "$log" >&2; }
    rm -f "$log"
    return "$status"
}
