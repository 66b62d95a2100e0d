#!/usr/bin/env bash
# A release in build/release, from a clean tree: packages, wheel, source distribution, checksums.  It pushes nothing.
#   tools/release.sh VERSION   VERSION is in version.h, and CHANGELOG.md has a section "## VERSION", as tools/CHANGELOG.md has one of
#                              the Python package's own version
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
fail() { echo "release.sh: $*" >&2 && exit 1; }

[ $# = 1 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0" >&2 && exit 1; }
version=$1 header=include/kalmanq/version.h out=build/release
IFS=. read -r major minor patch <<<"$version"
grep -q "KQ_VERSION_STRING \"$version\"" "$header" || fail "$header: KQ_VERSION_STRING is not \"$version\": set it there"
for part in "MAJOR $major" "MINOR $minor" "PATCH $patch"; do
    grep -qx "#define KQ_VERSION_$part" "$header" || fail "$header: KQ_VERSION_${part% *} is not ${part#* }: set it there"
done
grep -Eq "^## \[?${version//./\\.}\]?( |$)" CHANGELOG.md || fail "CHANGELOG.md has no section \"## $version\": name the section Unreleased so"
host=$(sed -n 's/^version = "\(.*\)"$/\1/p' tools/pyproject.toml)
grep -Eq "^## ${host//./\\.}( \(|$)" tools/CHANGELOG.md || fail "tools/CHANGELOG.md has no section \"## $host\" that says when: name the first section so"
[ -z "$(git status --porcelain)" ] || fail "the tree has changes: commit them"

rm -rf "$out" && mkdir -p "$out"
tools/package.sh all
for package in build/packages/*/; do
    name=$(basename "$package")
    case " arduino platformio zephyr esp-idf cmsis-pack conan vcpkg meson onefile rust " in
    *" $name "*) tar -C build/packages -czf "$out/kalmanq-$name-$version.tar.gz" "$name" ;;
    esac
done
git archive --prefix="kalmanq-$version/" -o "$out/kalmanq-source-$version.tar.gz" HEAD # kalmanq-VERSION.tar.gz is Python's
tools/package.sh wheel
cp build/packages/wheel/* "$out"
(cd "$out" && sha256sum -- * >SHA256SUMS && cat SHA256SUMS)
