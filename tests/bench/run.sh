#!/bin/bash
# Reconstructs dives and prints what came out as one JSON:
#   tests/bench/run.sh [--only trajectory,surface,speed] [--dive NAME,...] [--preset NAME,...]
#                      [--ablation NAME,...] [--repeat N] [--require] [--keep DIR] [--cache DIR]
# Dives: those of the shared data (DIVEMESH_SHARED, default ../shared) and simulated ones, which are
# rendered once into build/bench, anew when the simulator has changed. Builds what it needs first.
#   tests/bench/run.sh --only upload [--repeat N] [--require] [--large]
# Uploads instead of reconstructing; --large: a dive of 10 GB too.
#   tests/bench/run.sh --only bounds [--first-seed N] [--seeds N] [--no-shared] [--keep DIR] [--plot FILE]
# How often the bounds that reconstructions state about themselves hold.
#   tests/bench/run.sh --only compare [--vertices N,...] [--refused-vertices N] [--threads N]
# What comparing two models takes by their size, and how soon two places without common ground are refused.
#   tests/bench/run.sh --only reef [--first-seed N] [--seeds N] [--scenes tank,barge,reef] [--each] [--keep DIR]
# How often the intervals of reef metrics hold, over squares of the same dives; with the DIR of the
# bounds their reconstructions are not made again.
#   tests/bench/run.sh --only color [--scenes NAME,...] [--waters NAME,...] [--seed N] [--keep DIR]
# How true restored colours are (color=restored): against the reflectance that the simulator knows,
# and between two dives of one place in two waters.
#   tests/bench/run.sh --only envelope [--quick] [--axis NAME,...] [--keep DIR] [--table FILE] [--plot FILE]
# Where reconstruction ends: rate, calibration, light and the rest, each walked by itself until it breaks;
# docs/envelope.md has table and plot. With the DIR of an earlier run it goes on from there.
set -euo pipefail
cd "$(dirname "$0")/../.."
if [[ ${1:-} == --only && ${2:-} == upload ]]; then
    shift 2
    {
        cmake --preset release --log-level=WARNING
        cmake --build --preset release --target divemesh divemesh_upload_bench
    } >&2
    exec build/release/tests/bench/divemesh_upload_bench --program "$PWD/build/release/divemesh" "$@"
fi
if [[ ${1:-} == --only && ${2:-} == compare ]]; then
    shift 2
    {
        cmake --preset release --log-level=WARNING
        cmake --build --preset release --target divemesh divemesh_compare_bench
    } >&2
    maker=$(cat tests/bench/compared_place.* | sha256sum | cut -c1-12)
    exec build/release/tests/bench/divemesh_compare_bench --program "$PWD/build/release/divemesh" \
        --cache "build/bench/compare-$maker" "$@"
fi
if [[ ${1:-} == --only && ${2:-} == bounds ]]; then
    shift 2
    bench=divemesh_bounds
elif [[ ${1:-} == --only && ${2:-} == color ]]; then
    shift 2
    bench=divemesh_color_bench
elif [[ ${1:-} == --only && ${2:-} == envelope ]]; then
    shift 2
    bench=divemesh_envelope_bench
elif [[ ${1:-} == --only && ${2:-} == reef ]]; then
    shift 2
    bench=divemesh_reef_squares
else
    bench=divemesh_bench
fi
{
    cmake --preset release --log-level=WARNING
    cmake --build --preset release --target divemesh "$bench"
} >&2
simulator=$(cat worker/simulator/* | sha256sum | cut -c1-12)
exec "build/release/tests/bench/$bench" --program "$PWD/build/release/divemesh" \
    --cache "build/bench/dives-$simulator" "$@"
