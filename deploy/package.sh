#!/bin/bash
# Builds the packages for Debian 12 into build/release/packages.
#   deploy/package.sh [CMAKE OPTION...]      e.g. -DDIVEMESH_PACKAGE_CONTACT='Jo <jo@lab.example>'
# What it needs is installed by deploy/install.sh.
set -euo pipefail

case ${1:-} in
    -h | --help) sed -n '2,/^set /{/^set /!s/^# \{0,1\}//p}' "$0" && exit 0 ;;
esac
cd "$(dirname "$0")/.."

cmake --preset release --log-level=WARNING -DDIVEMESH_PAGE=ON "$@" >/dev/null
cmake --build --preset release --target divemesh
rm -rf build/release/packages
said=$(cd build/release && cpack 2>&1) || { echo "$said" >&2 && exit 1; }
ls -l build/release/packages/*.deb
