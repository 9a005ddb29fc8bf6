#pragma once

#include "worker/base/lanes.hpp"
#include "worker/fusion/packed_values.hpp"

// The functions of worker/fusion/packed_values.hpp for eight values at once, equal to the bit.
namespace divemesh::fusion {

DIVEMESH_INLINE_BODY base::Floats unpack_weights(base::Masks packed) {
    const base::Floats weights =
        reinterpret_cast<base::Floats>((packed << kWeightShift) + kWeightBase);
    return base::select(packed != 0, weights);
}
DIVEMESH_INLINE_BODY base::Masks pack_weights(base::Floats weights) {
    const base::Masks bits = reinterpret_cast<base::Masks>(weights) - kWeightBase;
    const base::Masks rounded = (bits + (1 << (kWeightShift - 1))) >> kWeightShift;
    const base::Masks at_least_one = rounded > 1 ? rounded : base::Masks{} + 1;
    return at_least_one < 0xffff ? at_least_one : base::Masks{} + 0xffff;
}

}  // namespace divemesh::fusion
