#!/bin/bash
# Installs, builds, and shows the whole way by `divemesh demo`: a dive goes in over the network, a worker
# reconstructs it, the artifacts come back, the metrics are printed.
#   deploy/demo.sh [--keep] [--preset NAME] [DIVE]
# DIVE: a folder or archive of your own; without it a dive along a sunken barge is rendered.
# --keep serves the results until Ctrl-C and prints an address that opens the page signed in.
set -euo pipefail

keep=--no-keep preset=standard dive=()
while (($#)); do
    case $1 in
        --keep) keep=--keep ;;
        --preset) preset=${2:?--preset needs a name} && shift ;;
        -h | --help) sed -n '2,/^set /{s/^# \{0,1\}//p}' "$0" && exit 0 ;;
        -*) echo "demo: unknown option $1" >&2 && exit 2 ;;
        *) dive=("$(realpath -e "$1")") ;;
    esac
    shift
done
cd "$(dirname "$0")/.."

deploy/install.sh
cmake --preset release --log-level=WARNING >/dev/null
cmake --build --preset release --target divemesh

demo=build/demo
rm -rf "$demo/data" "$demo/result" # of an earlier build
build/release/divemesh demo --out "$demo" --preset "$preset" "$keep" "${dive[@]}"
echo "demo: the results are in $PWD/$demo/result:"
ls -sh -I keyframes "$demo/result"
