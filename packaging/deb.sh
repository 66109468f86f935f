#!/bin/sh
# deb.sh VERSION: builds Debian packages from dist/libhtree-VERSION.tar.gz into dist/, in a folder of their own,
# and lets lintian look at them.
set -eu
cd "$(dirname "$0")/.."
version=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "dist/libhtree-$version.tar.gz" "$work/libhtree_$version.orig.tar.gz"
tar -C "$work" -xzf "$work/libhtree_$version.orig.tar.gz"
cp -r packaging/debian "$work/libhtree-$version/"
(cd "$work/libhtree-$version" && MAKEFLAGS='' dpkg-buildpackage -us -uc)
cp "$work"/*.deb "$work"/*.changes dist/
# No bug of Debian's asks for the package.
lintian --fail-on error,warning --allow-root --suppress-tags initial-upload-closes-no-bugs "$work"/*.changes
