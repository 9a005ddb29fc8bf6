#!/bin/bash
# Installs what builds, tests and runs divemesh on Debian 12 (deploy/packages.txt; with `--full` what
# deploy/test.sh --full needs as well: deploy/packages-full.txt). Does nothing when all of it is there.
# Never removes a package: stops and says which ones are in the way. Says which Node it found.
set -euo pipefail
cd "$(dirname "$0")/.."

lists=(deploy/packages.txt)
case ${1:-} in
    "") ;;
    --full) lists+=(deploy/packages-full.txt) ;;
    *)
        echo "usage: deploy/install.sh [--full]" >&2
        exit 2
        ;;
esac

missing=()
while read -r package; do
    [[ -z $package || $package == \#* ]] && continue
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' ||
        missing+=("$package")
done < <(cat "${lists[@]}")
# Where Node came from elsewhere, Debian's npm would conflict with it.
command -v node >/dev/null || missing+=(nodejs)
command -v npm >/dev/null || missing+=(npm)

# The tests run with whichever Node is found first: Debian's is 18, other people's differ from it.
say_node() {
    local node
    node=$(command -v node)
    echo "install: Node $("$node" --version) at $node, npm $(npm --version)"
}

if ((${#missing[@]} == 0)); then
    echo "install: every package is there"
    say_node
    exit 0
fi

as_root=(env DEBIAN_FRONTEND=noninteractive)
if ((EUID != 0)); then
    if ! command -v sudo >/dev/null; then
        echo "install: these packages are missing: ${missing[*]}" >&2
        echo "install: run deploy/install.sh as root, or install sudo" >&2
        exit 1
    fi
    as_root=(sudo DEBIAN_FRONTEND=noninteractive)
fi

echo "install: ${#missing[@]} packages: ${missing[*]}"
"${as_root[@]}" apt-get update -q
arguments=(install -q -y --no-remove --no-install-recommends "${missing[@]}")
plan=$("${as_root[@]}" apt-get install -s --no-install-recommends "${missing[@]}" 2>&1) || {
    echo "$plan" >&2
    echo "install: apt cannot install these packages together with what is on this machine" >&2
    exit 1
}
if removed=$(grep '^Remv ' <<<"$plan"); then
    echo "$removed" >&2
    echo "install: apt would remove the packages above (ROS and PCL use an older Boost)." >&2
    echo "install: nothing was changed; use another machine or a container of debian:12" >&2
    exit 1
fi
new_proxies=()
for proxy in nginx caddy; do
    dpkg-query -W "$proxy" >/dev/null 2>&1 || new_proxies+=("$proxy")
done
"${as_root[@]}" apt-get "${arguments[@]}"
# The tests start proxies of their own; those that apt has started on port 80 are of no use.
for proxy in "${new_proxies[@]}"; do
    "${as_root[@]}" service "$proxy" stop >/dev/null 2>&1 || true
    "${as_root[@]}" systemctl disable --quiet "$proxy" 2>/dev/null || true
done
say_node
