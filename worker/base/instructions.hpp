#pragma once

namespace divemesh::base {

// The instruction sets that inner loops are compiled for; each contains the ones before. All give
// the same integers: a loop is one source, compiled once per set (compiled_for). Loops that gain
// nothing from the widest set use the next narrower one. Only the rows of semi-global matching
// name instructions, because compilers do not find these in C++: bit counts by shuffles, tables in
// a register.
enum class Instructions { Baseline, Avx2, Avx512 };

// Returns the widest set that this machine can run.
inline Instructions best_instructions() {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bitalg") && __builtin_cpu_supports("avx512vbmi"))
        return Instructions::Avx512;
    if (__builtin_cpu_supports("avx2")) return Instructions::Avx2;
#endif
    return Instructions::Baseline;
}

// A loop body, compiled once for each instruction set that makes it faster.
template <auto body>
struct CompiledBody;
template <typename Result, typename... Arguments, Result (*body)(Arguments...)>
struct CompiledBody<body> {
    static Result for_baseline(Arguments... arguments) { return body(arguments...); }
#if defined(__x86_64__)
    __attribute__((target("avx2"))) static Result for_avx2(Arguments... arguments) {
        return body(arguments...);
    }
#else
    static constexpr auto for_avx2 = for_baseline;
#endif
};

// Returns the function `body`, a DIVEMESH_INLINE_BODY, as compiled for AVX2, or for the baseline if
// `instructions` is Baseline. Call it once before a loop, not inside.
template <auto body>
auto compiled_for(Instructions instructions) {
    return instructions == Instructions::Baseline ? CompiledBody<body>::for_baseline
                                                  : CompiledBody<body>::for_avx2;
}

}  // namespace divemesh::base

// Inlines a function into each caller, compiled for the caller's instruction set.
#define DIVEMESH_INLINE_BODY inline __attribute__((always_inline))
