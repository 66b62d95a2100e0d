#!/usr/bin/env bash
# three_commands.sh PYTHON WORK: the README's commands from nothing to a picture, in an environment without the package.
# Nothing is asked of the network.
set -euo pipefail
python=$1 work=$2
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
. "$here/environment.sh"
rm -rf "$work/user"
mkdir -p "$work"
environment "$python" "$work/user"
printf '#!/bin/sh\nexec "%s/bin/python" -m pip "$@"\n' "$work/user" >"$work/user/bin/pip"
chmod +x "$work/user/bin/pip"
cd "$root"
trap 'rm -f "$root/my.csv" "$root/my.png"' EXIT
commands=$(awk '/In a virtual environment:$/ { near = 1 } near && /^```$/ { exit } inside { print }
    near && /^```sh$/ { inside = 1 }' README.md)
made='python3 -m venv .venv && . .venv/bin/activate && '
[ "${commands#"$made"}" != "$commands" ] # the environment of this test takes its place
commands=${commands#"$made"}
[ "$(wc -l <<<"$commands")" = 3 ]
PATH="$work/user/bin:$PATH" PIP_NO_BUILD_ISOLATION=0 PIP_NO_DEPS=1 PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_QUIET=1 \
    bash -euxc "$commands"
file=$(od -An -c -N4 my.png | tr -d ' ')
[ "$file" = '211PNG' ] && echo "three commands: a picture"
