#!/bin/bash
# A fuzzer with a bug in its target has to fail, to leave the input, and to fail with it again:
#   finds_planted_bug.sh FUZZER
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

mkdir "$scratch/corpus"
printf '\003abc' >"$scratch/corpus/right"
if "$1" -max_total_time=30 -artifact_prefix="$scratch/" "$scratch/corpus" 2>"$scratch/log"; then
    echo "the planted bug was not found"
    exit 1
fi
left=("$scratch"/crash-*)
if "$1" -artifact_prefix="$scratch/again-" "${left[0]}" 2>"$scratch/log"; then
    echo "what was left is not what it fails with"
    exit 1
fi
grep -q heap-buffer-overflow "$scratch/log"
