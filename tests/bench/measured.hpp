#pragma once

#include <benchmark/benchmark.h>
#include <cstdint>

#include "tests/bench/machine_limit.hpp"

namespace divemesh::bench {

// Runs a kernel as often as the benchmark asks, where one run processes `num_units`. Adds counters
// of millions of `unit`s per second and, where the processor allows it, of instructions per unit.
// Returns the CPU time of one run, s.
template <typename Run>
double measure(benchmark::State& state, const char* unit, double num_units, Run&& run) {
    InstructionCounter counter;
    counter.start();
    const double start_s = thread_cpu_s();
    for ([[maybe_unused]] auto _ : state) run();
    const double run_s = (thread_cpu_s() - start_s) / static_cast<double>(state.iterations());
    const auto instructions = counter.stop();
    state.counters[std::string("M") + unit] =
        benchmark::Counter(1e-6 * num_units, benchmark::Counter::kIsIterationInvariantRate);
    if (instructions)
        state.counters[std::string("instructions/") + unit] =
            static_cast<double>(*instructions) /
            (num_units * static_cast<double>(state.iterations()));
    else
        state.SetLabel("no instruction counter on this machine");
    return run_s;
}

}  // namespace divemesh::bench
