#!/bin/bash
# Runs fuzzers on all cores, each for its share of the seconds, from tests/fuzz/corpus:
#   run.sh SECONDS FUZZER...
set -euo pipefail
corpus=$(cd "$(dirname "$0")" && pwd)/corpus
seconds=$1
shift

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export corpus scratch
export UBSAN_OPTIONS=halt_on_error=1:abort_on_error=1:print_stacktrace=1
export each=$((seconds * $(nproc) / $#))

fuzz() {
    local name=${1##*/fuzz_}
    mkdir -p "$scratch/$name" "$scratch/$name.tmp"
    # What the code under test logs is dropped; crashes and the fuzzer's own words are kept.
    if ! TMPDIR=$scratch/$name.tmp "$1" -max_total_time="$each" -max_len=16384 -timeout=10 \
        -rss_limit_mb=2048 -close_fd_mask=1 -print_final_stats=1 -verbosity=1 \
        -artifact_prefix="${1%/*}/${name}-" \
        "$scratch/$name" "$corpus/$name" >"$scratch/$name.log" 2>&1; then
        tail -n 60 "$scratch/$name.log"
        echo "$name: FAILED"
        return 1
    fi
    echo "$name: $(grep -c . <(ls "$corpus/$name")) seeds," \
        "$(awk '/number_of_executed_units/ {print $2}' "$scratch/$name.log") inputs in $each s"
}
export -f fuzz
printf '%s\0' "$@" | xargs -0 -P "$(nproc)" -I{} bash -c 'fuzz {}'
