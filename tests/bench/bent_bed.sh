#!/bin/bash
# The paper's figure 2 again: a plane of 6 m, its lenses stated wrong (k1 times 1.1), reconstructed
# with and without IMU and AHRS, lenses as given and refined. Prints one JSON line for
# each: how far the surface is from a plane (RMS, m), how much of that bends it
# along the way, and the error of the path.
#   tests/bench/bent_bed.sh [--preset NAME] [--images DIR] [--cache DIR]
# --images leaves the surfaces as seen from the side and from above.
set -euo pipefail
cd "$(dirname "$0")/../.."

preset=standard images='' cache=build/bench/bed
while (($#)); do
    case $1 in
        --preset) preset=${2:?--preset needs a name} && shift ;;
        --images) images=${2:?--images needs a folder} && shift ;;
        --cache) cache=${2:?--cache needs a folder} && shift ;;
        *) sed -n '2,/^set /{s/^# \{0,1\}//p}' "$0" >&2 && exit 2 ;;
    esac
    shift
done
{
    cmake --preset release --log-level=WARNING
    cmake --build --preset release --target divemesh alter_dive plane_fit
} >&2
divemesh=build/release/divemesh
simulator=$(cat worker/simulator/* | sha256sum | cut -c1-12)
bed=$cache/bed-$simulator
if [[ ! -d $bed ]]; then
    rm -rf "$bed.part"
    mkdir -p "$cache"
    "$divemesh" simulate --scene bed --length-m 6 --rate 10 --seed 1 --out "$bed.part" >&2
    mv "$bed.part" "$bed"
fi
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
build/release/tests/bench/alter_dive "$bed" "$results/bent" --k1-scale 1.1
if [[ -n $images ]]; then mkdir -p "$images"; fi

for lenses in given refined; do
    for imu in off on; do
        name=$lenses-imu-$imu
        switch=$([[ $imu == on ]] && echo true || echo false)
        refine=$([[ $lenses == refined ]] && echo true || echo false)
        "$divemesh" reconstruct "$results/bent" --out "$results/$name" --preset "$preset" \
            --no-texture --set use_imu="$switch" --set use_ahrs="$switch" \
            --set refine_lenses="$refine" >&2
        fit=$(build/release/tests/bench/plane_fit "$results/$name/mesh.ply" \
            ${images:+"$images/bed-$name.jpg"})
        ate=$(sed -n 's/.*"ate_rmse_m": \([0-9.e-]*\).*/\1/p' "$results/$name/metrics.json" | tail -1)
        echo "{\"lenses\": \"$lenses\", \"imu\": \"$imu\", \"ate_rmse_m\": $ate, ${fit#\{}"
    done
done
