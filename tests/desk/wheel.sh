#!/usr/bin/env bash
# wheel.sh PYTHON WORK: builds the package's wheel, installs it into a virtual environment that has its
# dependencies and nothing else of this project, and runs the tests beside this file there; then the README's three
# commands, in another one.  Nothing is asked of the network.
set -euo pipefail
python=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
rm -rf "$work/wheel" "$work/clean" "$work/user"
mkdir -p "$work"

# environment FOLDER: with the dependencies; `packages` is where its own are
environment() {
    "$python" -m venv --without-pip "$1"
    packages=$("$1/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    "$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))' >"$packages/dependencies.pth"
}

"$python" -m pip wheel -q --disable-pip-version-check --no-deps --no-build-isolation -w "$work/wheel" "$root/tools"
environment "$work/clean"
"$python" -m pip install -q --disable-pip-version-check --no-deps --target "$packages" "$work"/wheel/*.whl
cd "$here"
PYTHONDONTWRITEBYTECODE=1 "$work/clean/bin/python" -m pytest -q --no-header -p no:cacheprovider \
    --basetemp "$work/files" .

echo "== the README's commands"
environment "$work/user"
printf '#!/bin/sh\nexec "%s/bin/python" -m pip "$@"\n' "$work/user" >"$work/user/bin/pip"
chmod +x "$work/user/bin/pip"
cd "$root"
trap 'rm -f "$root/my.csv" "$root/my.png"' EXIT
commands=$(awk '/^From nothing|^command line. From nothing/ { near = 1 } near && /^```$/ { exit } inside { print }
    near && /^```sh$/ { inside = 1 }' README.md)
[ "$(wc -l <<<"$commands")" = 3 ]
PATH="$work/user/bin:$PATH" PIP_NO_BUILD_ISOLATION=0 PIP_NO_DEPS=1 PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_QUIET=1 \
    bash -euxc "$commands"
file=$(od -An -c -N4 my.png | tr -d ' ')
[ "$file" = '211PNG' ] && echo "three commands: a picture"
