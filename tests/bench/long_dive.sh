#!/usr/bin/env bash
# Makes a dive of many closed laps at the price of one: each lap has the images of the first, by
# hard links, and an IMU, pressure and truth of its own. For memory and time of long dives
# (docs/benchmarks.md): what a lap adds in noise to the surface is not in it.
#
#   tests/bench/long_dive.sh DIVEMESH OUT [LAPS]
set -euo pipefail

divemesh=$1
out=$2
laps=${3:-20}
swim=(simulate --scene barge --length-m 20 --rate 14)

work=$(mktemp -d "$(dirname "$out")/long_dive.XXXXXX")
trap 'rm -rf "$work"' EXIT
"$divemesh" "${swim[@]}" --laps 1 --out "$work/lap"
"$divemesh" "${swim[@]}" --laps "$laps" --width-px 32 --height-px 32 --out "$work/laps"

for camera in cam0 cam1; do
    from=$work/lap/mav0/$camera
    to=$work/laps/mav0/$camera
    cp "$from/sensor.yaml" "$to/sensor.yaml"
    mapfile -t images < <(tail -n +2 "$from/data.csv" | cut -d, -f2)
    i=0
    while IFS=, read -r _ name; do
        ln -f "$from/data/${images[i++ % ${#images[@]}]}" "$to/data/$name"
    done < <(tail -n +2 "$to/data.csv")
done
mv "$work/laps" "$out"
