#!/usr/bin/env bash
# platformio.sh WORK: `pio run` of first.c with the staged library.  PlatformIO's registry is not asked: SCons comes from PyPI,
# and its platform for a host has a stand-in.
set -euo pipefail
work=$1 root=$(cd "$(dirname "$0")/../../.." && pwd)
tools="$root/.deps/packagers/bin" # setup.sh, group packagers
export PLATFORMIO_CORE_DIR="$work/core" PLATFORMIO_SETTING_ENABLE_TELEMETRY=no PLATFORMIO_SETTING_CHECK_PLATFORMIO_INTERVAL=9999
rm -rf "$work" && mkdir -p "$work/src" "$work/core"
bash "$root/tools/package.sh" platformio

installed() { # KIND NAME VERSION FOLDER: as PlatformIO's package manager notes it
    mkdir -p "$4"
    printf '{"type": "%s", "name": "%s", "version": "%s", "spec": {"owner": "platformio", "id": null, "name": "%s", "requirements": null, "uri": null}}\n' \
        "$1" "$2" "$3" "$2" >"$4/.piopm"
}
scons="$work/core/packages/tool-scons" native="$work/core/platforms/native"
version=$("$tools/python" -c 'from platformio.dependencies import get_core_dependencies as all; print(all()["tool-scons"].lstrip("~"))')
installed tool tool-scons "$version" "$scons"
printf '{"name": "tool-scons", "version": "%s"}\n' "$version" >"$scons/package.json"
printf 'import SCons.Script\nSCons.Script.main()\n' >"$scons/scons.py"
installed platform native 1.2.1 "$native"
echo '{"name": "native", "title": "Native", "version": "1.2.1", "packages": {}, "description": "a stand-in", "license": "MIT",
"repository": {"type": "git", "url": "https://kalmanq.invalid/native.git"}}' >"$native/platform.json"
printf 'from platformio.public import PlatformBase\n\n\nclass NativePlatform(PlatformBase):\n    pass\n' >"$native/platform.py"
mkdir "$native/builder" && echo 'from SCons.Script import Default, DefaultEnvironment
env = DefaultEnvironment()
env.Replace(PROGNAME="program")
Default([env.BuildProgram()])' >"$native/builder/main.py"

cp "$root/tests/package/first.c" "$work/src"
printf '[env:native]\nplatform = native\nlib_deps = symlink://%s/build/packages/platformio\n' "$root" >"$work/platformio.ini"
"$tools/pio" run -d "$work" >"$work/said.txt" 2>&1 </dev/null || { tail -20 "$work/said.txt" && exit 1; }
[ "$("$work/.pio/build/native/program")" = "511.19 +- 0.90" ] && echo "pio run: 511.19 +- 0.90"
