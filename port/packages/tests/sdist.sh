#!/usr/bin/env bash
# sdist.sh PYTHON WORK: the source distribution of the staged tree, unpacked where nothing of the project is: it is
# configured, and has every file that the library is made of.  Nothing is compiled, nothing is asked of the network.
set -euo pipefail
python=$1 work=$2
root=$(cd "$(dirname "$0")/../../.." && pwd)
rm -rf "$work" && mkdir -p "$work"
"$python" -B "$root/port/packages/packages.py" python "$work/staged"
(cd "$work/staged" && "$python" -B -c 'from scikit_build_core.build import build_sdist; build_sdist("..")')
alone=$(mktemp -d) && trap 'rm -rf "$alone"' EXIT
tar -xzf "$work"/kalmanq-*.tar.gz -C "$alone" --strip-components 1
for folder in include src port/armv6m port/armv7m port/avr; do diff -r "$root/$folder" "$alone/core/$folder"; done
diff -r -x __pycache__ -x '_core.*.so' "$root/tools/kalmanq" "$alone/kalmanq"
grep -qx "Version: $(sed -n 's/^version = "\([^"]*\)".*/\1/p' "$root/tools/pyproject.toml")" "$alone/PKG-INFO"
cmake -G Ninja -S "$alone" -B "$alone/build" -DPython_EXECUTABLE="$python" >"$work/configured.txt" ||
    { cat "$work/configured.txt" && exit 1; }
# Every file that a step of the build needs is there
ninja -C "$alone/build" -t inputs all | grep '^/' | grep -v "^$alone/build/" >"$work/inputs.txt"
grep -q '/core/src/kq_status.c$' "$work/inputs.txt"
while read -r file; do [ -e "$file" ] || { echo "a step of the build needs $file" && exit 1; }; done <"$work/inputs.txt"
# Without the library it is refused, in words
rm -r "$alone/core" "$alone/build"
if cmake -S "$alone" -B "$alone/build" -DPython_EXECUTABLE="$python" >"$work/refused.txt" 2>&1; then exit 1; fi
grep -q 'tools/package.sh wheel makes' "$work/refused.txt"
echo "the source distribution stands by itself: $(tar -tzf "$work"/kalmanq-*.tar.gz | wc -l) files"
