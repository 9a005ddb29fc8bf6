#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <emmintrin.h>
#else
#include <cmath>
#endif

#include "worker/base/instructions.hpp"

// SIMD vectors of eight lanes: one source for every instruction set; on narrower sets the compiler
// splits the vectors. Only +, -, *, / and the square root are used. They round the same everywhere,
// so the results are equal to the bit. Files that include this are compiled with -Wno-psabi: the
// functions are inlined, so there is no ABI to warn about.
namespace divemesh::base {

inline constexpr int kLanes = 8;
using Floats = float __attribute__((vector_size(32)));
// 0 or -1 per lane, as comparisons return
using Masks = std::int32_t __attribute__((vector_size(32)));
using Shorts = std::uint16_t __attribute__((vector_size(16)));
using SignedShorts = std::int16_t __attribute__((vector_size(16)));

inline constexpr Masks kLaneNumbers = {0, 1, 2, 3, 4, 5, 6, 7};

template <typename Vector, typename Value>
DIVEMESH_INLINE_BODY Vector load_lanes(const Value* from) {
    static_assert(sizeof(Vector) == kLanes * sizeof(Value));
    Vector values;
    std::memcpy(&values, from, sizeof values);
    return values;
}
DIVEMESH_INLINE_BODY Floats load(const float* from) { return load_lanes<Floats>(from); }
template <typename Value, typename Vector>
DIVEMESH_INLINE_BODY void store(Value* to, Vector values) {
    static_assert(sizeof(Vector) == kLanes * sizeof(Value));
    std::memcpy(to, &values, sizeof values);
}
DIVEMESH_INLINE_BODY Floats broadcast(float value) { return Floats{} + value; }
DIVEMESH_INLINE_BODY Floats abs(Floats values) {
    return reinterpret_cast<Floats>(reinterpret_cast<Masks>(values) & 0x7fffffff);
}
// Returns the values where the mask is set, 0 elsewhere.
DIVEMESH_INLINE_BODY Floats select(Masks mask, Floats values) {
    return reinterpret_cast<Floats>(mask & reinterpret_cast<Masks>(values));
}
DIVEMESH_INLINE_BODY Floats max(Floats a, Floats b) { return a > b ? a : b; }
DIVEMESH_INLINE_BODY Floats min(Floats a, Floats b) { return a < b ? a : b; }
// Returns the values rounded towards 0.
DIVEMESH_INLINE_BODY Masks to_integers(Floats values) {
    return __builtin_convertvector(values, Masks);
}
// Returns true if the mask is set in any lane.
DIVEMESH_INLINE_BODY bool any(Masks mask) {
#if defined(__SSE2__)
    __m128i halves[2];
    std::memcpy(halves, &mask, sizeof halves);
    return _mm_movemask_epi8(_mm_or_si128(halves[0], halves[1])) != 0;
#else
    std::uint64_t words[4];
    std::memcpy(words, &mask, sizeof words);
    return (words[0] | words[1] | words[2] | words[3]) != 0;
#endif
}
DIVEMESH_INLINE_BODY Floats square_root(Floats values) {
#if defined(__SSE2__)
    __m128 halves[2];
    std::memcpy(halves, &values, sizeof values);
    for (__m128& half : halves) half = _mm_sqrt_ps(half);
    std::memcpy(&values, halves, sizeof values);
#else
    for (int i = 0; i < kLanes; ++i) values[i] = std::sqrt(values[i]);
#endif
    return values;
}

// Transposes an 8 x 8 block: rows[i][j] becomes rows[j][i].
DIVEMESH_INLINE_BODY void transpose(Floats (&rows)[kLanes]) {
    Floats pairs[kLanes];
    for (int i = 0; i < kLanes; i += 2) {
        pairs[i] = __builtin_shufflevector(rows[i], rows[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        pairs[i + 1] = __builtin_shufflevector(rows[i], rows[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    Floats fours[kLanes];
    for (int half = 0; half < kLanes; half += 4)
        for (int i = 0; i < 2; ++i) {
            const Floats a = pairs[half + i];
            const Floats b = pairs[half + i + 2];
            fours[half + 2 * i] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
            fours[half + 2 * i + 1] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
        }
    for (int i = 0; i < 4; ++i) {
        rows[i] = __builtin_shufflevector(fours[i], fours[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        rows[i + 4] = __builtin_shufflevector(fours[i], fours[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

}  // namespace divemesh::base
