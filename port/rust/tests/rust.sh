#!/usr/bin/env bash
# rust.sh HOW WORK [LIBRARY]: the crate of port/rust.
#   bindings  what bindings.py declares are the functions and objects that the headers name, and LIBRARY has them
#   host      the crate as tools/package.sh stages it, its package and its tests
#   chip      a program on an emulated Cortex-M4F answers what it does here, bit for bit
# Crates come from where setup.sh has fetched them; nothing is asked of the network.
set -euo pipefail
how=$1 work=$2 library=${3:-}
root=$(cd "$(dirname "$0")/../../.." && pwd)
crate="$root/port/rust" chip="$root/port/rust/tests/chip" target=thumbv7em-none-eabihf
export CARGO_NET_OFFLINE=true CARGO_TARGET_DIR="$work/target"
mkdir -p "$work"

# core for the chip, of Debian's source and compiler; what core's compiler_builtins would bring is in libgcc and newlib
sysroot() {
    local rustc=$1 libraries="$work/sysroot/lib/rustlib/$target/lib" source
    source=$(ls -d /usr/src/rustc-"$("$rustc" --version | sed 's/rustc \([0-9.]*\).*/\1/')"*/library/core/src/lib.rs)
    mkdir -p "$libraries"
    local flags=(--edition 2024 --crate-type rlib --target "$target" -C panic=abort --cap-lints allow)
    [ -f "$libraries/libcore.rlib" ] ||
        RUSTC_BOOTSTRAP=1 "$rustc" --crate-name core -C opt-level=s "${flags[@]}" -o "$libraries/libcore.rlib" "$source"
    echo '#![no_std] #![feature(compiler_builtins)] #![compiler_builtins]' |
        RUSTC_BOOTSTRAP=1 "$rustc" --crate-name compiler_builtins --sysroot "$work/sysroot" "${flags[@]}" \
            -o "$libraries/libcompiler_builtins.rlib" -
}

case $how in
bindings)
    version=$(sed -n 's/.*KQ_VERSION_STRING "\(.*\)"/\1/p' "$root/include/kalmanq/version.h")
    grep -qx "version = \"$version\"" "$crate/Cargo.toml" || { echo "Cargo.toml has another version than version.h" && exit 1; }
    python3 -B "$crate/bindings.py" "$work/sys.rs"
    sed -n 's/^    pub \(fn\|static\) \(kq_[a-z0-9_]*\).*/\2/p' "$work/sys.rs" | LC_ALL=C sort >"$work/declared"
    nm -g --defined-only "$library" | awk '{ print $3 }' | LC_ALL=C sort -u >"$work/defined"
    cat "$root"/include/kalmanq/*.h | grep -o '\bkq_[a-z0-9_]*' | LC_ALL=C sort -u | LC_ALL=C comm -12 - "$work/defined" >"$work/public"
    diff "$work/public" "$work/declared" || { echo "bindings.py declares other functions than headers and library have" && exit 1; }
    echo "bindings of $(grep -c 'pub fn' "$work/sys.rs") functions are the headers'"
    ;;
host)
    bash "$root/tools/package.sh" rust --check
    (cd "$root/build/packages/rust" && cargo test)
    echo "the crate's tests hold"
    ;;
chip)
    rustc=/usr/bin/rustc # Debian's, whose source of core is there
    sysroot "$rustc"
    python3 -B "$crate/bindings.py"
    cd "$chip"
    RUSTC=$rustc cargo run --release >"$work/host.txt"
    RUSTC=$rustc CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS="--sysroot $work/sysroot -C linker=arm-none-eabi-gcc" \
        cargo build --release --target "$target"
    timeout "${KQ_TIME_LIMIT:-600}" qemu-system-arm -M mps2-an386 -nographic -semihosting \
        -kernel "$work/target/$target/release/chip" >"$work/chip.txt"
    # the program in C of include/README.md prints these raw values
    words=$(sed -n 's/^[0-9]  *\([0-9]*\) +- \([0-9]*\) raw:.*/[\1, \2]/p' "$root/include/README.md" | paste -sd, | sed 's/,\[/, [/g')
    grep -qxF "q31 [$words]" "$work/chip.txt" || { echo "in C: q31 [$words]" && cat "$work/chip.txt" && exit 1; }
    grep -q '^sizes true done Ok' "$work/chip.txt" && diff "$work/host.txt" "$work/chip.txt"
    cat "$work/chip.txt"
    arm-none-eabi-size "$work/target/$target/release/chip"
    echo "the chip answers what the host does"
    ;;
esac
