#!/bin/bash
# Installs, builds and passes all tests: with sanitizers, and optimised those for which that matters.
# `--full` adds what takes longer: all of them optimised, thread sanitizer, linter, every dive of the
# shared data, the demo, and in a fresh Debian 12 the packages, the demo and these tests.
# A test that is skipped without a reason on tests/allowed_skips.txt fails it.
set -euo pipefail
cd "$(dirname "$0")/.."

full=false
case ${1:-} in
    "") ;;
    --full) full=true ;;
    *)
        echo "usage: deploy/test.sh [--full]" >&2
        exit 2
        ;;
esac

timings=()
step() {
    local name=$1 start=$SECONDS
    shift
    echo "=== $name"
    "$@"
    timings+=("$(printf '%6d s  %s' $((SECONDS - start)) "$name")")
}
results=$PWD/build/test-results
rm -rf "$results"
jobs=$(($(nproc) + 1)) # some tests wait for clocks and other processes most of their time
# run_tests NAME ARGUMENTS...: ctest, its results in NAME.xml.
run_tests() {
    local name=$1
    shift
    ctest --output-junit "$results/$name.xml" "$@"
}
print_slowest_tests() {
    local file
    for file in "$results"/*.xml; do
        sed -nE 's|.*<testcase name="([^"]*)".* time="([^"]*)".*|\2 '"$(basename "$file" .xml)"' \1|p' "$file"
    done | sort -gr | awk 'NR <= 10 { printf "%8.1f s  %s, %s\n", $1, $3, $2 }'
}
report() {
    if [[ -d $results ]]; then
        echo "=== the ten slowest tests"
        print_slowest_tests
    fi
    echo "=== steps"
    printf '%s\n' "${timings[@]}" "$(printf '%6d s  in all' "$SECONDS")"
}
trap report EXIT

check_format() { git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run -Werror; }
install_npm_packages() {
    local folder
    for folder in tests/end_to_end/js tests/deploy/js; do
        npm ci --prefix "$folder" --no-audit --no-fund --loglevel=error
    done
}
check_page() {
    npm ci --prefix web --no-audit --no-fund --loglevel=error
    npm run check --prefix web && npm test --prefix web
}
build() {
    local preset=$1
    shift
    cmake --preset "$preset" --log-level=WARNING >/dev/null && cmake --build --preset "$preset" "$@"
}
lint_contract() {
    npm ci --prefix tests/api/lint --no-audit --no-fund --loglevel=error
    tests/api/lint/node_modules/.bin/spectral lint --fail-severity=warn \
        --ruleset tests/api/lint/spectral.yaml api/openapi.yaml
    local said
    said=$(REDOCLY_TELEMETRY=off REDOCLY_SUPPRESS_UPDATE_NOTICE=true tests/api/lint/node_modules/.bin/redocly lint \
        --config tests/api/lint/redocly.yaml --max-problems 1000 api/openapi.yaml 2>&1) &&
        [[ $said != *[Ww]arning* ]] || { echo "$said" >&2 && return 1; }
}
# The linter reads no precompiled headers, and without them no file may miss an include.
build_plainly() { cmake --preset release -B build/plain -DDIVEMESH_PRECOMPILE=OFF --log-level=WARNING >/dev/null && cmake --build build/plain; }
can_make_clean_root() {
    command -v mmdebstrap >/dev/null && { ((EUID != 0)) || unshare --mount --pid --fork true; }
}
# Where systemd cannot run in namespaces, it says so.
test_packages() { deploy/test_package.sh || (($? == 77)); }
lint() { git ls-files '*.cpp' | grep -v ^tests/ | xargs -P "$(nproc)" -n 4 clang-tidy -p build/plain --quiet; }

if $full; then
    step "install packages" deploy/install.sh --full
else
    step "install packages" deploy/install.sh
fi
step "install validators and clients (npm)" install_npm_packages
step "format" check_format
step "types and tests of the page (npm)" check_page
step "build, release" build release --target divemesh release_tests benchmarks
step "build, address and undefined-behaviour sanitizers" build debug --target unit_tests fuzzers
step "unit tests, sanitizers" run_tests debug --preset debug -j "$jobs"
step "fuzzers, 60 s for all of them" run_tests debug-fuzz --test-dir build/debug -L fuzz -V
step "tests, release" run_tests release --preset release -L 'release|long|slow' -j "$jobs"
step "skipped tests" tests/check_skips.sh "$results"/*.xml

if $full; then
    step "long unit tests, sanitizers" run_tests debug-long --test-dir build/debug -L long --output-on-failure
    step "build all, release" build release
    step "all tests, release" run_tests release-all --preset release
    step "build, fuzzers that follow what they cover" build fuzz
    step "these fuzzers, 60 s for all of them" run_tests fuzz --preset fuzz -V
    step "build, server tests, address and undefined-behaviour sanitizers" build debug-server
    step "server tests, address and undefined-behaviour sanitizers" run_tests debug-server --preset debug-server -j "$(nproc)"
    step "build, thread sanitizer" build tsan --target unit_tests
    step "unit tests, thread sanitizer" run_tests tsan --preset tsan
    step "build, server tests, thread sanitizer" build tsan-server
    step "server tests, thread sanitizer" run_tests tsan-server --preset tsan-server -j "$(nproc)"
    step "build, release, without precompiled headers" build_plainly
    step "linter" lint
    step "10,000 jobs, 8 workers, 100 kills" build/release/tests/bench/divemesh_queue_storm
    step "the contract by spectral and redocly" lint_contract
    step "every dive of the shared data" tests/bench/run.sh
    step "uploads, with a dive of 10 GB over a link that breaks" tests/bench/run.sh --only upload --large --repeat 3
    step "skipped tests, of all runs" tests/check_skips.sh "$results"/*.xml
    step "demo" deploy/demo.sh
    step "packages" deploy/package.sh
    if can_make_clean_root; then
        step "packages in a fresh Debian 12" test_packages
        step "demo and tests in a fresh Debian 12" deploy/clean_root.sh
    else
        echo "=== left out: a fresh Debian 12 (no mmdebstrap, or this machine lets us mount nothing)"
    fi
fi
