#!/usr/bin/env bash
# modules.sh zephyr|esp-idf|cmsis-pack WORK: the module or component, in place and staged, in an application for an emulated
# Cortex-M4F.  Kconfig and module.yml are read by their own programs; CMake's functions have stand-ins (modules/).  Of a
# CMSIS pack, what its description lists for f32 is compiled.
set -euo pipefail
how=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
python="$root/.deps/packagers/bin/python" # setup.sh, group packagers
# shellcheck source=tests/target/cores.sh
. "$root/tests/target/cores.sh"
core_select m4f
rm -rf "$work" && mkdir -p "$work"

read -r cc link <<<"$linker"
link=$(tr ' ' '\n' <<<"$link" | grep -vxFf <(tr ' ' '\n' <<<"$compiler") | tr '\n' ' ')
printf '%s\n' 'set(CMAKE_SYSTEM_NAME Generic)' "set(CMAKE_C_COMPILER $cc)" \
    "set(CMAKE_C_FLAGS_INIT \"${compiler#* } -Wall -Wextra -Werror\")" 'set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)' \
    "set(CMAKE_EXE_LINKER_FLAGS_INIT \"$link -Wl,--gc-sections\")" >"$work/toolchain.cmake"

# application NAME MODULE OPTION...
application() {
    local name=$1 module=$2
    shift 2
    cmake --no-warn-unused-cli -S "$here/modules" -B "$work/$name" "-DCMAKE_TOOLCHAIN_FILE=$work/toolchain.cmake" -DCMAKE_BUILD_TYPE=MinSizeRel \
        -DHOW="$how" -DMODULE="$module" -DPROGRAM="$root/tests/package/first.c" "$@" >"$work/$name.txt"
    cmake --build "$work/$name" -j2 >>"$work/$name.txt" || { cat "$work/$name.txt" && return 1; }
    # shellcheck disable=SC2086
    timeout "${KQ_TIME_LIMIT:-600}" $emulator "$work/$name/application" </dev/null >"$work/said.txt"
    grep -qx '511.19 +- 0.90' "$work/said.txt" && echo "$how, $name: $(cat "$work/said.txt")"
}

# configured FOLDER LINE...: what an application's prj.conf makes of the Kconfig that the module of FOLDER names, as options
# of CMake; first its folder with a CMakeLists.txt
configured() {
    "$python" - "$@" <<'END'
import sys
from pathlib import Path
import kconfiglib
import yaml
folder, lines = Path(sys.argv[1]).resolve(), sys.argv[2:]
module = yaml.safe_load((folder / "zephyr/module.yml").read_text())
assert set(module) == {"name", "build"} and set(module["build"]) == {"cmake", "kconfig"}, module
kconfig = kconfiglib.Kconfig(str(folder / module["build"]["kconfig"]))
Path("prj.conf").write_text("\n".join(lines) + "\n")
kconfig.load_config("prj.conf")
sys.exit("\n".join(kconfig.warnings)) if kconfig.warnings else None
print(folder / module["build"]["cmake"])
for name, symbol in kconfig.syms.items():
    if name.startswith("KALMANQ") and symbol.str_value == "y":
        print(f"-DCONFIG_{name}=y")
END
}

# listed KIND: the files of that kind in the pack's components status and f32
listed() {
    "$python" - "$root/build/packages/cmsis-pack/kalmanq.kalmanq.pdsc" "$1" <<'END'
import sys
import xml.etree.ElementTree as tree
for component in tree.parse(sys.argv[1]).getroot().iter("component"):
    if component.get("Csub") in ("status", "f32"):
        print(*(file.get("name") for file in component.iter("file") if file.get("category") == sys.argv[2]), sep="\n")
END
}

pack() {
    local folders files
    folders=$(listed include | sed 's/^./-I&/') files=$(listed source)
    # shellcheck disable=SC2086
    (cd "$root/build/packages/cmsis-pack" && $compiler -std=c11 -Os -Wall -Wextra -Werror -ffunction-sections $folders -c $files \
        "$root/tests/package/first.c" && mv ./*.o "$work")
    # shellcheck disable=SC2086
    $linker -Wl,--gc-sections "$work"/*.o -lm -o "$work/first"
    # shellcheck disable=SC2086
    [ "$(timeout "${KQ_TIME_LIMIT:-600}" $emulator "$work/first" </dev/null)" = "511.19 +- 0.90" ]
}

# zephyr NAME FOLDER LINE...
zephyr() {
    local options
    options=$(cd "$work" && configured "${@:2}") && mapfile -t options <<<"$options"
    application "$1" "${options[@]}"
}

libraries_of() { (cd "$1" && find . -name '*.a' -exec "$nm" {} + | sed -n 's/.* T \(kq_predict_[a-z0-9]*\)$/\1/p' | sort | tr '\n' ' '); }

bash "$root/tools/package.sh" "$how"
case $how in
zephyr)
    zephyr in_place "$root/port/packages" CONFIG_KALMANQ=y
    [ "$(libraries_of "$work/in_place")" = "kq_predict_f32 " ]
    zephyr staged "$root/build/packages/zephyr" CONFIG_KALMANQ=y CONFIG_KALMANQ_F64=y CONFIG_KALMANQ_Q31=y
    [ "$(libraries_of "$work/staged" | wc -w)" = 3 ]
    ;;
esp-idf)
    application in_place "$root/port/packages/esp-idf/kalmanq"
    mkdir "$work/components" && cp -r "$root/build/packages/esp-idf" "$work/components/kalmanq"
    application staged "$work/components/kalmanq"
    ;;
cmsis-pack) pack ;;
esac
echo "$how: the program runs"
