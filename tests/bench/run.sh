#!/bin/bash
# Reconstructs the dives of the shared data (DIVEMESH_SHARED, default ../shared) and prints what came
# out as one JSON: tests/bench/run.sh [--only trajectory,surface,speed] [--dive NAME,...]
# [--repeat N] [--require] [--keep DIR]. Builds what it needs first.
set -euo pipefail
cd "$(dirname "$0")/../.."
{
    cmake --preset release --log-level=WARNING
    cmake --build --preset release --target divemesh divemesh_bench
} >&2
exec build/release/tests/bench/divemesh_bench --program "$PWD/build/release/divemesh" "$@"
