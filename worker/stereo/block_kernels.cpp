#include "worker/stereo/block_kernels.hpp"

#include <algorithm>

namespace divemesh::stereo {
namespace {

using Sum = std::uint16_t;
using Byte = std::uint8_t;

DIVEMESH_INLINE_BODY void accumulate(
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

DIVEMESH_INLINE_BODY void slide(Sum* __restrict cost,
                                const Sum* __restrict entering,
                                const Sum* __restrict leaving,
                                int num) {
    for (int d = 0; d < (num & ~31); ++d)
        cost[d] = static_cast<Sum>(cost[d] + entering[d] - leaving[d]);
}

DIVEMESH_INLINE_BODY Sum min_cost(const Sum* cost, int num) {
    Sum min_cost = 0xffff;
    for (int d = 0; d < (num & ~31); ++d) min_cost = std::min(min_cost, cost[d]);
    return min_cost;
}

DIVEMESH_INLINE_BODY int find(const Sum* cost, Sum value, int num) {
    Sum first = 0xffff;
    for (int d = 0; d < (num & ~31); ++d)
        first = std::min(first, cost[d] == value ? static_cast<Sum>(d) : Sum{0xffff});
    return first;
}

}  // namespace

BlockKernels block_kernels(base::Instructions instructions) {
    return {base::compiled_for<accumulate>(instructions),
            base::compiled_for<slide>(instructions),
            base::compiled_for<min_cost>(instructions),
            base::compiled_for<find>(instructions)};
}

}  // namespace divemesh::stereo
