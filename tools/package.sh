#!/usr/bin/env bash
# Packages: stages a tree for a package manager in build/packages/NAME and looks it over.
#   tools/package.sh NAME          arduino, platformio, zephyr, esp-idf, cmsis-pack, conan, vcpkg, meson, onefile, python, rust, all
#   tools/package.sh NAME --check  and the ecosystem's own checker, where it is installed
#   tools/package.sh wheel         python's source distribution and wheel in build/packages/wheel, tried where only NumPy is
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
packages="$root/build/packages"
version=$(sed -n 's/.*KQ_VERSION_STRING "\(.*\)"/\1/p' "$root/include/kalmanq/version.h")
all="arduino platformio zephyr esp-idf cmsis-pack conan vcpkg meson onefile python rust"

fail() { echo "package.sh: $*" >&2 && exit 1; }
has() { command -v "$1" >/dev/null || { echo "$name: not checked by $1, which is not installed" && return 1; }; }

# The version is the header's, and what a manifest names is there
look_over() {
    case $name in
    arduino) grep -qx "version=$version" library.properties && compile src src/kq_filter_f32.c kalmanq.h ;;
    platformio) [ "$(python3 -c 'import json; print(json.load(open("library.json"))["version"])')" = "$version" ] ;;
    zephyr) [ -f port/packages/zephyr/Kconfig ] && [ -f port/packages/zephyr/CMakeLists.txt ] &&
        [ "$(grep -c port/packages/zephyr zephyr/module.yml)" = 2 ] ;;
    esp-idf) grep -qx "version: \"$version\"" idf_component.yml && [ -f src/kq_status.c ] &&
        ! grep -q '/\.\.' CMakeLists.txt ;;
    cmsis-pack) look_over_pack ;;
    conan) python3 -m py_compile conanfile.py test_package/conanfile.py && rm -r __pycache__ test_package/__pycache__ &&
        grep -qx "    version = \"$version\"" conanfile.py ;;
    vcpkg) [ "$(python3 -c 'import json; print(json.load(open("kalmanq/vcpkg.json"))["version"])')" = "$version" ] ;;
    meson) grep -q "version: '$version'" kalmanq/meson.build && listed kalmanq kalmanq/meson.build ;;
    onefile) compile . kalmanq_f32.c kalmanq.h && look_over_archive "kalmanq-$version-onefile.zip" ;;
    rust) grep -qx "version = \"$version\"" Cargo.toml && [ -f core/src/kq_status.c ] && grep -q 'pub fn kq_step_q31(' src/sys.rs ;;
    python) ! grep -q '[.][.]/' pyproject.toml && [ -f core/src/kq_status.c ] ;;
    esac
}

listed() { # FOLDER MANIFEST: the sources that it names are all that there are
    [ "$(grep -o 'kq_[a-z0-9_]*\.c' "$2" | sort)" = "$(cd "$1/src" && printf '%s\n' kq_*.c | sort)" ]
}

look_over_pack() {
    python3 - kalmanq.kalmanq.pdsc "$version" <<'END'
import sys, pathlib, xml.etree.ElementTree as tree
pack = tree.parse(sys.argv[1]).getroot()
names = [file.get("name") for file in pack.iter("file")]
missing = [name for name in names if not pathlib.Path(name).exists()]
versions = {part.get("Cversion") for part in pack.iter("component")} | {part.get("version") for part in pack.iter("release")}
conditions = {part.get("id") for part in pack.iter("condition")}
used = {part.get("condition") for part in pack.iter("component")} - {None}
sources = {f"src/{path.name}" for path in pathlib.Path("src").glob("kq_*.c")} - set(names)
sys.exit(bool(missing or versions != {sys.argv[2]} or used - conditions or sources != {"src/kq_prepare_q31.c"}))
END
}

look_over_archive() { # ZIP: its sum is the one beside it, and what is in it is the folder
    rm -rf ../unpacked
    (cd .. && sha256sum --quiet -c "$1.sha256") && python3 -m zipfile -e "../$1" ../unpacked && diff -r . ../unpacked && rm -r ../unpacked
}

compile() { # INCLUDE FILE HEADER
    echo "#include <$3>" | cc -std=c11 -I"$1" -x c -fsyntax-only - && cc -std=c11 -w -I"$1" -fsyntax-only "$2"
}

# The program of a checker; a package whose checker is not installed is passed over, and that is said
checker() {
    case $name in
    arduino) echo arduino-builder ;;
    platformio) echo pio ;;
    zephyr) echo west ;;
    esp-idf) echo compote ;;
    cmsis-pack) echo xmllint ;;
    onefile | python) echo cc ;;
    rust) echo cargo ;;
    *) echo "$name" ;;
    esac
}

# The first readings of the sketch on an emulated Uno, whose input 0 has 2.5 V.  Debian's core lacks DECIMAL_DIG.
arduino_sketch() {
    local work="$packages/arduino_work" ctags=/usr/bin/arduino-ctags hardware=/usr/share/arduino/hardware
    rm -rf "$work" && mkdir -p "$work/build" "$work/libraries" && cp -r . "$work/libraries/kalmanq"
    arduino-builder -hardware $hardware -tools /usr/share/arduino -libraries "$work/libraries" -fqbn arduino:avr:uno \
        -build-path "$work/build" -prefs tools.ctags.cmd.path=$ctags -prefs runtime.tools.avr-gcc.path=/usr \
        -prefs 'tools.ctags.pattern="{cmd.path}" -u --language-force=c++ -f - --c++-kinds=svpf --fields=KSTtzns --line-directives "{source_file}"' \
        -prefs compiler.path=/usr/bin/ -prefs compiler.cpp.extra_flags=-DDECIMAL_DIG=10 examples/first/first.ino || return 1
    cc -O2 "$root/port/boards/avr_emulator.c" -o "$work/emulator" -lsimavr && yes 2500 | head -400 >"$work/voltages"
    KQ_AVR_CYCLES=30 KQ_AVR_VOLTAGES="$work/voltages" "$work/emulator" --part "$work/build/first.ino.elf" | tr -d "\r" >"$work/said" || true
    [ "$(sort "$work/said" | uniq -c | sort -rn | awk 'NR == 1 { print $2 }')" = 511.00 ] && echo "an emulated Uno says 511.00"
}

check() {
    [ "$name" = python ] || local PATH="$root/.deps/packagers/bin:$PATH" # setup.sh, group packagers
    has "$(checker)" || return 0
    case $name in
    arduino) arduino_sketch ;;
    platformio) pio_pack ;;
    zephyr) zephyr_module ;;
    esp-idf) compote component pack --name kalmanq --dest-dir "$packages" ;;
    cmsis-pack) xmllint --noout kalmanq.kalmanq.pdsc ;;
    conan) export CONAN_HOME="$packages/conan_home" && conan profile detect --force && conan create . --no-remote ;;
    vcpkg) vcpkg install kalmanq --overlay-ports=. ;;
    meson) meson_program ;;
    python) wheel ;;
    rust) CARGO_NET_OFFLINE=true CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$packages/rust_target}" cargo package --allow-dirty ;;
    onefile) one_file ;;
    esac
}

# Size and time of each file, with the flags that the page names
one_file() {
    local file TIMEFORMAT='%U'
    echo "kalmanq.h: $(wc -c <kalmanq.h) bytes; $(cc --version | head -1)"
    for file in kalmanq_*.c; do
        { time cc -std=c11 -O2 -ffunction-sections -fno-math-errno -ffp-contract=off -c "$file" -o "$packages/onefile.o"; } 2>"$packages/onefile.txt" ||
            { cat "$packages/onefile.txt" && return 1; }
        echo "$file: $(wc -c <"$file") bytes, compiled in $(tail -1 "$packages/onefile.txt") s of processor time"
    done
    rm "$packages/onefile.txt"
}

# A workspace that has the module as its manifest; Kconfig without a warning
zephyr_module() {
    local workspace="$packages/west"
    rm -rf "$workspace" && mkdir -p "$workspace/app"
    printf 'manifest:\n  projects:\n    - name: kalmanq\n      url: file://%s\n' "$PWD" >"$workspace/app/west.yml"
    (cd "$workspace/app" && west init -l . && west manifest --validate) &&
        python3 -c 'import kconfiglib, sys; sys.exit(len(kconfiglib.Kconfig("port/packages/zephyr/Kconfig").warnings))'
}

# PlatformIO fetches the list of licences; without it a manifest is refused.
pio_pack() {
    python3 - "$packages/kalmanq_platformio.tar.gz" <<'END'
import sys
from platformio.package.manifest import schema
from platformio.package.pack import PackagePacker
schema.ManifestSchema.load_spdx_licenses = staticmethod(lambda: {"licenses": [{"licenseId": "MIT"}]})
print(PackagePacker(".").pack(sys.argv[1]))
END
}

meson_program() {
    local program="$packages/meson_program"
    rm -rf "$program" && mkdir -p "$program/subprojects"
    cp -r ./* "$program/subprojects" && cp "$root/tests/package/first.c" "$program"
    printf "project('first', 'c')\nexecutable('first', 'first.c', dependencies: dependency('kalmanq'))\n" >"$program/meson.build"
    meson setup "$program/build" "$program" && meson compile -C "$program/build" && "$program/build/first"
}

# A wheel out of the source distribution alone; for older systems, too, where auditwheel finds that it is
wheel() {
    local out="$packages/wheel" tools
    # shellcheck source=tools/setup.sh
    . "$root/tools/setup.sh" && kq_setup wheel && tools=$(dirname "$KQ_WHEEL_PYTHON") || return 1
    rm -rf "$out" && mkdir -p "$out/raw"
    kq_quietly "$KQ_WHEEL_PYTHON" -m build --no-isolation --outdir "$out/raw" . && mv "$out"/raw/*.tar.gz "$out" || return 1
    "$tools/auditwheel" show "$out"/raw/*.whl | tr -s '\n' ' ' && echo &&
        PATH="$tools:$PATH" kq_quietly "$tools/auditwheel" repair -w "$out" "$out"/raw/*.whl && rm -r "$out/raw" || return 1
    kq_quietly "$tools/abi3audit" --strict "$out"/*.whl && echo "abi3audit: the limited API of the wheel's tag" || return 1
    python3 -m venv "$packages/wheel_tried" --clear &&
        "$packages/wheel_tried/bin/python" -m pip install -q --disable-pip-version-check --no-index \
            --find-links "$KQ_WHEEL_HOUSE" "$out"/*.whl || return 1
    (cd "$packages" && "$KQ_WHEEL_PYTHON" -m mypy --strict --python-executable wheel_tried/bin/python \
        --cache-dir wheel_tried/mypy "$root/port/packages/tests/typed_user.py" &&
        wheel_tried/bin/python "$root/port/packages/tests/wheel_alone.py" "$out")
}

[ $# -ge 1 ] && [ $# -le 2 ] && [ "${2:---check}" = --check ] || { sed -n '2,5s/^# \{0,1\}//p' "$0" >&2 && exit 1; }
[ "$1" != wheel ] || set -- python --check
names=$1
[ "$names" != all ] || names=$all
for name in $names; do
    python3 "$root/port/packages/packages.py" "$name" "$packages/$name"
    cd "$packages/$name"
    look_over || fail "$name: build/packages/$name does not hold together"
    [ "${2:-}" != --check ] || check || fail "$name: its checker found faults"
    echo "$name $version: build/packages/$name"
done
