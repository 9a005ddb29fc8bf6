#pragma once

namespace divemesh::worker {

// What the inner loops are compiled for, each set containing the ones before. Every set gives the
// same integers: the loops are one source, compiled once per set. Loops that gain nothing from the
// widest set use the next narrower one.
enum class Instructions { Baseline, Avx2, Avx512 };

// The widest set that this machine runs.
inline Instructions best_instructions() {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bitalg"))
        return Instructions::Avx512;
    if (__builtin_cpu_supports("avx2")) return Instructions::Avx2;
#endif
    return Instructions::Baseline;
}

}  // namespace divemesh::worker

// A loop body that is compiled into each of its callers, and a caller compiled for AVX2.
#define DIVEMESH_INLINE_BODY inline __attribute__((always_inline))
#if defined(__x86_64__)
#define DIVEMESH_FOR_AVX2 __attribute__((target("avx2")))
#else
#define DIVEMESH_FOR_AVX2
#endif
