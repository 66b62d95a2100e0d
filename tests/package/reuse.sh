#!/usr/bin/env bash
# reuse.sh WORK: `reuse lint` of the tree, with the licence's text where it looks for it: LICENSES/MIT.txt is LICENSE.
set -euo pipefail
work=$1 root=$(cd "$(dirname "$0")/../.." && pwd)
rm -rf "$work" && mkdir -p "$work/LICENSES"
(cd "$root" && git ls-files -co --exclude-standard -z | tar --null -T - -c) | tar -x -C "$work"
cp "$root/LICENSE" "$work/LICENSES/MIT.txt"
PATH="$root/.deps/packagers/bin:$PATH" # setup.sh, group packagers
reuse --root "$work" lint
