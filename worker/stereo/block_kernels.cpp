#include "worker/stereo/block_kernels.hpp"

#include <algorithm>

namespace divemesh::worker {
namespace {

using Sum = std::uint16_t;
using Byte = std::uint8_t;

DIVEMESH_INLINE_BODY void accumulate_body(
    Sum* __restrict cost, Byte left, const Byte* __restrict right, int num, int sign) {
    if (sign > 0)
        for (int d = 0; d < (num & ~31); ++d) {
            const Byte r = right[d];
            cost[d] = static_cast<Sum>(cost[d] +
                                       static_cast<Byte>(std::max(left, r) - std::min(left, r)));
        }
    else
        for (int d = 0; d < (num & ~31); ++d) {
            const Byte r = right[d];
            cost[d] = static_cast<Sum>(cost[d] -
                                       static_cast<Byte>(std::max(left, r) - std::min(left, r)));
        }
}

DIVEMESH_INLINE_BODY void slide_body(Sum* __restrict cost,
                                     const Sum* __restrict entering,
                                     const Sum* __restrict leaving,
                                     int num) {
    for (int d = 0; d < (num & ~31); ++d)
        cost[d] = static_cast<Sum>(cost[d] + entering[d] - leaving[d]);
}

DIVEMESH_INLINE_BODY Sum least_body(const Sum* cost, int num) {
    Sum least = 0xffff;
    for (int d = 0; d < (num & ~31); ++d) least = std::min(least, cost[d]);
    return least;
}

DIVEMESH_INLINE_BODY int find_body(const Sum* cost, Sum value, int num) {
    Sum first = 0xffff;
    for (int d = 0; d < (num & ~31); ++d)
        first = std::min(first, cost[d] == value ? static_cast<Sum>(d) : Sum{0xffff});
    return first;
}

void accumulate(Sum* cost, Byte left, const Byte* right, int num, int sign) {
    accumulate_body(cost, left, right, num, sign);
}
void slide(Sum* cost, const Sum* entering, const Sum* leaving, int num) {
    slide_body(cost, entering, leaving, num);
}
Sum least(const Sum* cost, int num) { return least_body(cost, num); }
int find(const Sum* cost, Sum value, int num) { return find_body(cost, value, num); }

DIVEMESH_FOR_AVX2 void accumulate_avx2(Sum* cost, Byte left, const Byte* right, int num, int sign) {
    accumulate_body(cost, left, right, num, sign);
}
DIVEMESH_FOR_AVX2 void slide_avx2(Sum* cost, const Sum* entering, const Sum* leaving, int num) {
    slide_body(cost, entering, leaving, num);
}
DIVEMESH_FOR_AVX2 Sum least_avx2(const Sum* cost, int num) { return least_body(cost, num); }
DIVEMESH_FOR_AVX2 int find_avx2(const Sum* cost, Sum value, int num) {
    return find_body(cost, value, num);
}

}  // namespace

BlockKernels block_kernels(Instructions instructions) {
    if (instructions != Instructions::Baseline)
        return {accumulate_avx2, slide_avx2, least_avx2, find_avx2};
    return {accumulate, slide, least, find};
}

}  // namespace divemesh::worker
