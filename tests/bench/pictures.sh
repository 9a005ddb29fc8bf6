#!/bin/bash
# Draws finished reconstructions to be looked at: mesh.glb from above, obliquely, from an end and
# from near, the mosaic and the heights, as PNG. Ghosts of fish, seams, smears, holes and wrong
# colours are defects; magenta is where a mesh has nothing.
#   tests/bench/pictures.sh [--out DIR] RESULT...
# RESULT: folders of `divemesh reconstruct --out`. Their images lie in DIR (build/bench/pictures) in
# folders of the same names.
set -euo pipefail
cd "$(dirname "$0")/../.."

out=build/bench/pictures results=()
while (($#)); do
    case $1 in
        --out) out=${2:?--out needs a folder} && shift ;;
        -*) sed -n '2,/^set /{s/^# \{0,1\}//p}' "$0" >&2 && exit 2 ;;
        *) results+=("$1") ;;
    esac
    shift
done
if ((${#results[@]} == 0)); then
    sed -n '2,/^set /{s/^# \{0,1\}//p}' "$0" >&2
    exit 2
fi
{
    cmake --preset release --log-level=WARNING
    cmake --build --preset release --target divemesh_pictures
} >&2
for result in "${results[@]}"; do
    build/release/tests/bench/divemesh_pictures "$result" "$out/$(basename "$result")"
done
