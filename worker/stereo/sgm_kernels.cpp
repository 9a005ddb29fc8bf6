#include "worker/stereo/sgm_kernels.hpp"

#include <algorithm>

namespace divemesh::worker {
namespace {

using Byte = std::uint8_t;

// Bits set in each pair, then each nibble, of a byte.
DIVEMESH_INLINE_BODY Byte nibble_counts(Byte bits) {
    const auto pairs = static_cast<Byte>(bits - ((bits >> 1) & 0x55));
    return static_cast<Byte>((pairs & 0x33) + ((pairs >> 2) & 0x33));
}

DIVEMESH_INLINE_BODY Byte byte_count(Byte nibbles) {
    return static_cast<Byte>((nibbles & 0x0f) + (nibbles >> 4));
}

DIVEMESH_INLINE_BODY Byte saturating_sum(Byte a, Byte b) {
    return static_cast<Byte>(std::min<Byte>(a, static_cast<Byte>(255 - b)) + b);
}

DIVEMESH_INLINE_BODY void census_distance(const ForwardPixel& pixel) {
    const int num = pixel.num_disparities & ~31;
    const Byte* __restrict r0 = pixel.right[0];
    const Byte* __restrict r1 = pixel.right[1];
    const Byte* __restrict r2 = pixel.right[2];
    const Byte* __restrict r3 = pixel.right[3];
    Byte* __restrict cost = pixel.cost;
    const Byte l0 = pixel.left[0], l1 = pixel.left[1], l2 = pixel.left[2], l3 = pixel.left[3];
    for (int d = 0; d < num; ++d) {
        const auto n01 = static_cast<Byte>(nibble_counts(static_cast<Byte>(l0 ^ r0[d])) +
                                           nibble_counts(static_cast<Byte>(l1 ^ r1[d])));
        const auto n23 = static_cast<Byte>(nibble_counts(static_cast<Byte>(l2 ^ r2[d])) +
                                           nibble_counts(static_cast<Byte>(l3 ^ r3[d])));
        cost[d] = static_cast<Byte>(byte_count(n01) + byte_count(n23));
    }
    for (int d = pixel.num_in_image; d < num; ++d) cost[d] = kNumCensusBits;
}

// L(p, d) = C(p, d) + min(L(q, d), L(q, d +- 1) + P1, min L(q) + P2) - min L(q); eq. 14 there.
DIVEMESH_INLINE_BODY Byte path_cost(const Byte* before, int d, Byte least, Byte far) {
    const Byte near = static_cast<Byte>(std::min(before[d - 1], before[d + 1]) + kSmallStepPenalty);
    return static_cast<Byte>(std::min(std::min(before[d], near), far) - least);
}

DIVEMESH_INLINE_BODY void forward_body(ForwardPixel& pixel) {
    census_distance(pixel);
    const int num = pixel.num_disparities & ~31;
    const Byte* __restrict cost = pixel.cost;
    Byte* __restrict sum = pixel.sum;
    const Byte* __restrict b0 = pixel.paths[0].before;
    const Byte* __restrict b1 = pixel.paths[1].before;
    const Byte* __restrict b2 = pixel.paths[2].before;
    const Byte* __restrict b3 = pixel.paths[3].before;
    Byte* __restrict h0 = pixel.paths[0].here;
    Byte* __restrict h1 = pixel.paths[1].here;
    Byte* __restrict h2 = pixel.paths[2].here;
    Byte* __restrict h3 = pixel.paths[3].here;
    Byte least[4];
    Byte far[4];
    for (int p = 0; p < 4; ++p) {
        least[p] = pixel.paths[p].before_min;
        far[p] = static_cast<Byte>(least[p] + pixel.paths[p].step_penalty);
    }
    Byte m0 = 255, m1 = 255, m2 = 255, m3 = 255;
#pragma GCC ivdep  // the buffers are apart, too many for the compiler to check
    for (int d = 0; d < num; ++d) {
        const auto c0 = static_cast<Byte>(path_cost(b0, d, least[0], far[0]) + cost[d]);
        const auto c1 = static_cast<Byte>(path_cost(b1, d, least[1], far[1]) + cost[d]);
        const auto c2 = static_cast<Byte>(path_cost(b2, d, least[2], far[2]) + cost[d]);
        const auto c3 = static_cast<Byte>(path_cost(b3, d, least[3], far[3]) + cost[d]);
        h0[d] = c0;
        h1[d] = c1;
        h2[d] = c2;
        h3[d] = c3;
        m0 = std::min(m0, c0);
        m1 = std::min(m1, c1);
        m2 = std::min(m2, c2);
        m3 = std::min(m3, c3);
        sum[d] = saturating_sum(saturating_sum(c0, c1), saturating_sum(c2, c3));
    }
    pixel.paths[0].here_min = m0;
    pixel.paths[1].here_min = m1;
    pixel.paths[2].here_min = m2;
    pixel.paths[3].here_min = m3;
}

DIVEMESH_INLINE_BODY void backward_body(BackwardPixel& pixel) {
    const int num = pixel.num_disparities & ~31;
    const Byte* __restrict cost = pixel.cost;
    Byte* __restrict sum = pixel.sum;
    const Byte* __restrict before = pixel.path.before;
    Byte* __restrict here = pixel.path.here;
    const Byte least = pixel.path.before_min;
    const auto far = static_cast<Byte>(least + pixel.path.step_penalty);
    Byte path_min = 255;
    Byte best = 255;
    for (int d = 0; d < num; ++d) {
        const auto c = static_cast<Byte>(path_cost(before, d, least, far) + cost[d]);
        const Byte s = saturating_sum(sum[d], c);
        here[d] = c;
        sum[d] = s;
        path_min = std::min(path_min, c);
        best = std::min(best, s);
    }
    pixel.path.here_min = path_min;
    pixel.best = best;
}

DIVEMESH_INLINE_BODY Byte least_body(const Byte* values, int num) {
    Byte least = 255;
    for (int i = 0; i < (num & ~31); ++i) least = std::min(least, values[i]);
    return least;
}

DIVEMESH_INLINE_BODY void census_body(const Byte* center,
                                      const Byte* const* neighbours,
                                      int num,
                                      Byte* __restrict plane) {
    const Byte* __restrict c = center;
    for (int k = 0; k < 8; ++k) {
        const Byte* __restrict n = neighbours[k];
        const auto bit = static_cast<Byte>(1 << k);
        for (int x = 0; x < num; ++x)
            plane[x] = static_cast<Byte>((k == 0 ? 0 : plane[x]) | (n[x] >= c[x] ? bit : 0));
    }
}

void forward_baseline(ForwardPixel& pixel) { forward_body(pixel); }
void backward_baseline(BackwardPixel& pixel) { backward_body(pixel); }
Byte least_baseline(const Byte* values, int num) { return least_body(values, num); }
void census_baseline(const Byte* center, const Byte* const* neighbours, int num, Byte* plane) {
    census_body(center, neighbours, num, plane);
}

DIVEMESH_FOR_AVX2 void forward_avx2(ForwardPixel& pixel) { forward_body(pixel); }
DIVEMESH_FOR_AVX2 void backward_avx2(BackwardPixel& pixel) { backward_body(pixel); }
DIVEMESH_FOR_AVX2 Byte least_avx2(const Byte* values, int num) { return least_body(values, num); }
DIVEMESH_FOR_AVX2 void census_avx2(const Byte* center,
                                   const Byte* const* neighbours,
                                   int num,
                                   Byte* plane) {
    census_body(center, neighbours, num, plane);
}

}  // namespace

SgmKernels sgm_kernels(Instructions instructions) {
    if (instructions == Instructions::Avx2)
        return {forward_avx2, backward_avx2, least_avx2, census_avx2};
    return {forward_baseline, backward_baseline, least_baseline, census_baseline};
}

}  // namespace divemesh::worker
