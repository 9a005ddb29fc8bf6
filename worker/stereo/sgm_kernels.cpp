#include "worker/stereo/sgm_kernels.hpp"

#include <algorithm>
#include <cstring>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

// One namespace per instruction set, each with the vector type, its operations and, by inclusion,
// the loops. No standard header may be included after a target pragma: its inline functions would
// be compiled for that target and then be used by the whole program.
namespace divemesh::stereo {
namespace {

namespace baseline {

constexpr int kBytes = 16;
using V = std::uint8_t __attribute__((vector_size(kBytes)));

DIVEMESH_INLINE_BODY V load(const std::uint8_t* from) {
    V v;
    std::memcpy(&v, from, kBytes);
    return v;
}
DIVEMESH_INLINE_BODY void store(std::uint8_t* to, V v) { std::memcpy(to, &v, kBytes); }
DIVEMESH_INLINE_BODY V broadcast(int value) { return V{} + static_cast<std::uint8_t>(value); }
DIVEMESH_INLINE_BODY V min(V a, V b) { return a < b ? a : b; }
DIVEMESH_INLINE_BODY V add(V a, V b) { return a + b; }
DIVEMESH_INLINE_BODY V subtract(V a, V b) { return a - b; }
DIVEMESH_INLINE_BODY V add_saturated(V a, V b) {
    const V sum = a + b;
    return sum < a ? broadcast(255) : sum;
}
DIVEMESH_INLINE_BODY V first_or(V v, int num, int other) {
    constexpr V kPlace = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    return kPlace < broadcast(std::clamp(num, 0, kBytes)) ? v : broadcast(other);
}
DIVEMESH_INLINE_BODY int min_byte(V v) {
    using Words = std::uint64_t __attribute__((vector_size(kBytes)));
    for (const int shift : {32, 16, 8})
        v = min(v, reinterpret_cast<V>(reinterpret_cast<Words>(v) >> shift));
    return std::min(v[0], v[8]);
}
DIVEMESH_INLINE_BODY std::uint64_t where_equal(V a, V b) {
    const V ones = (a == b) ? broadcast(1) : broadcast(0);
    std::uint64_t halves[2];
    std::memcpy(halves, &ones, kBytes);
    // Byte i, 0 or 1, times 2^(56 - 7 i) is bit i of the highest byte.
    constexpr std::uint64_t kGather = 0x0102040810204080U;
    return ((halves[0] * kGather) >> 56) | (((halves[1] * kGather) >> 56) << 8);
}
// Returns how many of the first `num` bytes are <= limit.
DIVEMESH_INLINE_BODY int num_at_most(V a, V limit, int /*num: all*/) {
    const V ones = (min(a, limit) == a) ? broadcast(1) : broadcast(0);
    std::uint64_t halves[2];
    std::memcpy(halves, &ones, kBytes);
    constexpr std::uint64_t kSum = 0x0101010101010101U;  // into the highest byte
    return static_cast<int>(((halves[0] + halves[1]) * kSum) >> 56);
}
DIVEMESH_INLINE_BODY V broadcast_where_equal(V a, V b, int value) {
    return (a == b) ? broadcast(value) : broadcast(0);
}
// Return the bytes at d - 1, where `before` ends at the first byte of `here`, and those at d + 1.
#if defined(__SSE2__)
DIVEMESH_INLINE_BODY V one_lower(V before, V here) {
    return reinterpret_cast<V>(_mm_or_si128(_mm_slli_si128(reinterpret_cast<__m128i>(here), 1),
                                            _mm_srli_si128(reinterpret_cast<__m128i>(before), 15)));
}
DIVEMESH_INLINE_BODY V one_upper(V here, V after) {
    return reinterpret_cast<V>(_mm_or_si128(_mm_srli_si128(reinterpret_cast<__m128i>(here), 1),
                                            _mm_slli_si128(reinterpret_cast<__m128i>(after), 15)));
}
#else
DIVEMESH_INLINE_BODY V one_lower(V before, V here) {
    return __builtin_shufflevector(
        before, here, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30);
}
DIVEMESH_INLINE_BODY V one_upper(V here, V after) {
    return __builtin_shufflevector(
        here, after, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16);
}
#endif

#include "worker/stereo/sgm_minima.simd.hpp"

// Returns the number of bits set in each nibble.
DIVEMESH_INLINE_BODY V nibble_counts(V bits) {
    const V pairs = bits - ((bits >> 1) & broadcast(0x55));
    return (pairs & broadcast(0x33)) + ((pairs >> 2) & broadcast(0x33));
}
DIVEMESH_INLINE_BODY V byte_counts(V nibbles) {
    return (nibbles & broadcast(0x0f)) + (nibbles >> 4);
}
DIVEMESH_INLINE_BODY V hamming(const V* left, const std::uint8_t* const* right, int d) {
    V nibbles[4];
    for (int p = 0; p < 4; ++p) nibbles[p] = nibble_counts(left[p] ^ load(right[p] + d));
    return byte_counts(nibbles[0] + nibbles[1]) + byte_counts(nibbles[2] + nibbles[3]);
}

#include "worker/stereo/sgm_rows.simd.hpp"

}  // namespace baseline

#if defined(__x86_64__)

#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {

constexpr int kBytes = 32;
using V = __m256i;

DIVEMESH_INLINE_BODY V load(const std::uint8_t* from) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
}
DIVEMESH_INLINE_BODY void store(std::uint8_t* to, V v) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), v);
}
DIVEMESH_INLINE_BODY V broadcast(int value) { return _mm256_set1_epi8(static_cast<char>(value)); }
DIVEMESH_INLINE_BODY V min(V a, V b) { return _mm256_min_epu8(a, b); }
DIVEMESH_INLINE_BODY V add(V a, V b) { return _mm256_add_epi8(a, b); }
DIVEMESH_INLINE_BODY V subtract(V a, V b) { return _mm256_sub_epi8(a, b); }
DIVEMESH_INLINE_BODY V add_saturated(V a, V b) { return _mm256_adds_epu8(a, b); }
DIVEMESH_INLINE_BODY V first_or(V v, int num, int other) {
    const V place = _mm256_setr_epi8(0,
                                     1,
                                     2,
                                     3,
                                     4,
                                     5,
                                     6,
                                     7,
                                     8,
                                     9,
                                     10,
                                     11,
                                     12,
                                     13,
                                     14,
                                     15,
                                     16,
                                     17,
                                     18,
                                     19,
                                     20,
                                     21,
                                     22,
                                     23,
                                     24,
                                     25,
                                     26,
                                     27,
                                     28,
                                     29,
                                     30,
                                     31);
    const int first = num < 0 ? 0 : num > kBytes ? kBytes : num;
    return _mm256_blendv_epi8(broadcast(other), v, _mm256_cmpgt_epi8(broadcast(first), place));
}
DIVEMESH_INLINE_BODY int min_byte(V v) {
    const __m128i halves = _mm_min_epu8(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const __m128i pairs = _mm_min_epu8(halves, _mm_srli_epi16(halves, 8));
    return _mm_cvtsi128_si32(_mm_minpos_epu16(pairs)) & 0xff;
}
DIVEMESH_INLINE_BODY std::uint64_t where_equal(V a, V b) {
    return static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_cmpeq_epi8(a, b)));
}
DIVEMESH_INLINE_BODY int num_at_most(V a, V limit, int /*num: all*/) {
    return __builtin_popcountll(where_equal(min(a, limit), a));
}
DIVEMESH_INLINE_BODY V broadcast_where_equal(V a, V b, int value) {
    return _mm256_and_si256(_mm256_cmpeq_epi8(a, b), broadcast(value));
}
DIVEMESH_INLINE_BODY V one_lower(V before, V here) {
    return _mm256_alignr_epi8(here, _mm256_permute2x128_si256(before, here, 0x21), 15);
}
DIVEMESH_INLINE_BODY V one_upper(V here, V after) {
    return _mm256_alignr_epi8(_mm256_permute2x128_si256(here, after, 0x21), here, 1);
}

#include "worker/stereo/sgm_minima.simd.hpp"  // NOLINT(readability-duplicate-include): once per set

DIVEMESH_INLINE_BODY V by_nibble(V table, V bits) {
    const V low = _mm256_set1_epi8(0x0f);
    return _mm256_add_epi8(
        _mm256_shuffle_epi8(table, _mm256_and_si256(bits, low)),
        _mm256_shuffle_epi8(table, _mm256_and_si256(_mm256_srli_epi16(bits, 4), low)));
}
// First adds the bits of three planes to a sum and a carry; the carry counts twice.
DIVEMESH_INLINE_BODY V hamming(const V* left, const std::uint8_t* const* right, int d) {
    const V ones = _mm256_setr_epi8(0,
                                    1,
                                    1,
                                    2,
                                    1,
                                    2,
                                    2,
                                    3,
                                    1,
                                    2,
                                    2,
                                    3,
                                    2,
                                    3,
                                    3,
                                    4,
                                    0,
                                    1,
                                    1,
                                    2,
                                    1,
                                    2,
                                    2,
                                    3,
                                    1,
                                    2,
                                    2,
                                    3,
                                    2,
                                    3,
                                    3,
                                    4);
    const V twos = _mm256_add_epi8(ones, ones);
    const V a = _mm256_xor_si256(left[0], load(right[0] + d));
    const V b = _mm256_xor_si256(left[1], load(right[1] + d));
    const V c = _mm256_xor_si256(left[2], load(right[2] + d));
    const V e = _mm256_xor_si256(left[3], load(right[3] + d));
    const V a_or_b = _mm256_xor_si256(a, b);
    const V sum = _mm256_xor_si256(a_or_b, c);
    const V carry = _mm256_or_si256(_mm256_and_si256(a, b), _mm256_and_si256(a_or_b, c));
    return _mm256_add_epi8(by_nibble(twos, carry),
                           _mm256_add_epi8(by_nibble(ones, sum), by_nibble(ones, e)));
}

#include "worker/stereo/sgm_rows.simd.hpp"  // NOLINT(readability-duplicate-include): once per set

}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512vl,avx512vbmi,avx512bitalg")
namespace avx512 {

constexpr int kBytes = 64;
using V = __m512i;

DIVEMESH_INLINE_BODY V load(const std::uint8_t* from) { return _mm512_loadu_si512(from); }
DIVEMESH_INLINE_BODY void store(std::uint8_t* to, V v) { _mm512_storeu_si512(to, v); }
DIVEMESH_INLINE_BODY V broadcast(int value) { return _mm512_set1_epi8(static_cast<char>(value)); }
DIVEMESH_INLINE_BODY V min(V a, V b) { return _mm512_min_epu8(a, b); }
DIVEMESH_INLINE_BODY V add(V a, V b) { return _mm512_add_epi8(a, b); }
DIVEMESH_INLINE_BODY V subtract(V a, V b) { return _mm512_sub_epi8(a, b); }
DIVEMESH_INLINE_BODY V add_saturated(V a, V b) { return _mm512_adds_epu8(a, b); }
DIVEMESH_INLINE_BODY V first_or(V v, int num, int other) {
    const int first = num < 0 ? 0 : num > kBytes ? kBytes : num;
    const __mmask64 keep = first == kBytes ? ~__mmask64{0} : (__mmask64{1} << first) - 1;
    return _mm512_mask_blend_epi8(keep, broadcast(other), v);
}
DIVEMESH_INLINE_BODY std::uint64_t where_equal(V a, V b) { return _mm512_cmpeq_epi8_mask(a, b); }
DIVEMESH_INLINE_BODY int num_at_most(V a, V limit, int num) {
    const __mmask64 all = _mm512_cmple_epu8_mask(a, limit);
    return __builtin_popcountll(num < kBytes ? all & ((__mmask64{1} << num) - 1) : all);
}
DIVEMESH_INLINE_BODY V broadcast_where_equal(V a, V b, int value) {
    return _mm512_maskz_mov_epi8(_mm512_cmpeq_epi8_mask(a, b), broadcast(value));
}
// The bytes first, first + 1, first + 2, ...
struct Places {
    constexpr explicit Places(int first) {
        for (int i = 0; i < kBytes; ++i) bytes[i] = static_cast<std::uint8_t>(first + i);
    }
    alignas(kBytes) std::uint8_t bytes[kBytes] = {};
};
constexpr Places kOneLower(kBytes - 1);
constexpr Places kOneUpper(1);
DIVEMESH_INLINE_BODY V one_lower(V before, V here) {
    return _mm512_permutex2var_epi8(before, load(kOneLower.bytes), here);
}
DIVEMESH_INLINE_BODY V one_upper(V here, V after) {
    return _mm512_permutex2var_epi8(here, load(kOneUpper.bytes), after);
}
// The minima, in the lowest byte of each of four words.
using PathMinima = __m128i;
DIVEMESH_INLINE_BODY PathMinima path_minima(const V (&v)[4]) {
    // Without a mask g++ 12 warns about its own header (bug 105593).
    constexpr __mmask8 kAll = 0xff;
    constexpr __mmask16 kAllWords = 0xffff;
    __m512 pairs_of[2];
    for (int i = 0; i < 2; ++i) {
        const V* const two = v + std::ptrdiff_t{2} * i;
        pairs_of[i] = _mm512_castsi512_ps(min(_mm512_maskz_unpacklo_epi64(kAll, two[0], two[1]),
                                              _mm512_maskz_unpackhi_epi64(kAll, two[0], two[1])));
    }
    const V all = min(
        _mm512_castps_si512(_mm512_maskz_shuffle_ps(kAllWords, pairs_of[0], pairs_of[1], 0x88)),
        _mm512_castps_si512(_mm512_maskz_shuffle_ps(kAllWords, pairs_of[0], pairs_of[1], 0xdd)));
    const __m256i halves = _mm256_min_epu8(_mm512_maskz_extracti64x4_epi64(kAll, all, 0),
                                           _mm512_maskz_extracti64x4_epi64(kAll, all, 1));
    const __m128i words =
        _mm_min_epu8(_mm256_castsi256_si128(halves), _mm256_extracti128_si256(halves, 1));
    const __m128i pairs = _mm_min_epu8(words, _mm_srli_epi32(words, 16));
    return _mm_min_epu8(pairs, _mm_srli_epi32(pairs, 8));
}
template <int p>
DIVEMESH_INLINE_BODY std::uint8_t min_of_path(PathMinima minima) {
    return static_cast<std::uint8_t>(_mm_extract_epi8(minima, 4 * p));
}
DIVEMESH_INLINE_BODY V broadcast_last(PathMinima minima) {
    return _mm512_maskz_broadcastb_epi8(~__mmask64{0}, _mm_srli_si128(minima, 12));
}
DIVEMESH_INLINE_BODY V hamming(const V* left, const std::uint8_t* const* right, int d) {
    V counts[4];
    for (int p = 0; p < 4; ++p)
        counts[p] = _mm512_popcnt_epi8(_mm512_xor_si512(left[p], load(right[p] + d)));
    return _mm512_add_epi8(_mm512_add_epi8(counts[0], counts[1]),
                           _mm512_add_epi8(counts[2], counts[3]));
}

#include "worker/stereo/sgm_rows.simd.hpp"  // NOLINT(readability-duplicate-include): once per set

}  // namespace avx512
#pragma GCC pop_options

#endif

}  // namespace

SgmKernels sgm_kernels(base::Instructions instructions) {
#if defined(__x86_64__)
    if (instructions == base::Instructions::Avx512) return avx512::kernels();
    if (instructions != base::Instructions::Baseline) return avx2::kernels();
#endif
    return baseline::kernels();
}

}  // namespace divemesh::stereo
