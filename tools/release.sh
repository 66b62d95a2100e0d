#!/usr/bin/env bash
# A release in build/release, from a clean tree: packages, wheel, source distribution, checksums.  It pushes nothing.
#   tools/release.sh VERSION   VERSION is in version.h, and CHANGELOG.md has a section "## VERSION"
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
fail() { echo "release.sh: $*" >&2 && exit 1; }

[ $# = 1 ] || { sed -n '2,3s/^# \{0,1\}//p' "$0" >&2 && exit 1; }
version=$1 header=include/kalmanq/version.h out=build/release
IFS=. read -r major minor patch <<<"$version"
grep -q "KQ_VERSION_STRING \"$version\"" "$header" || fail "$header: KQ_VERSION_STRING is not \"$version\": set it there"
for part in "MAJOR $major" "MINOR $minor" "PATCH $patch"; do
    grep -qx "#define KQ_VERSION_$part" "$header" || fail "$header: KQ_VERSION_${part% *} is not ${part#* }: set it there"
done
grep -Eq "^## \[?${version//./\\.}\]?( |$)" CHANGELOG.md || fail "CHANGELOG.md has no section \"## $version\": name the section Unreleased so"
[ -z "$(git status --porcelain)" ] || fail "the tree has changes: commit them"
python=${KQ_TOOLS_PYTHON:-python3}
"$python" -c 'import build' 2>/dev/null || fail "$python has no module build: pip install build auditwheel"

rm -rf "$out" && mkdir -p "$out"
tools/package.sh all
for package in build/packages/*/; do
    name=$(basename "$package")
    case " arduino platformio zephyr esp-idf cmsis-pack conan vcpkg meson onefile " in
    *" $name "*) tar -C build/packages -czf "$out/kalmanq-$name-$version.tar.gz" "$name" ;;
    esac
done
git archive --prefix="kalmanq-$version/" -o "$out/kalmanq-$version.tar.gz" HEAD
"$python" -m build --wheel tools --outdir "$out"
if "$python" -c 'import auditwheel' 2>/dev/null; then # what it needs of the C library, in its name
    PATH="$(dirname "$(command -v "$python")"):$PATH" "$python" -m auditwheel repair -w "$out/repaired" "$out"/*.whl
    rm "$out"/*.whl && mv "$out/repaired"/*.whl "$out" && rmdir "$out/repaired"
else
    echo "release.sh: no auditwheel: the wheel is for this system only" >&2
fi
(cd "$out" && sha256sum -- * >SHA256SUMS && cat SHA256SUMS)
