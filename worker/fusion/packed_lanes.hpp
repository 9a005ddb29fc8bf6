#pragma once

#include "worker/base/lanes.hpp"
#include "worker/fusion/packed_values.hpp"

// worker/fusion/packed_values.hpp for eight values at once, to the bit.
namespace divemesh::worker {

DIVEMESH_INLINE_BODY Floats unpack_weights(Masks packed) {
    const Floats weights = reinterpret_cast<Floats>((packed << kWeightShift) + kWeightBase);
    return select(packed != 0, weights);
}
DIVEMESH_INLINE_BODY Masks pack_weights(Floats weights) {
    const Masks bits = reinterpret_cast<Masks>(weights) - kWeightBase;
    const Masks rounded = (bits + (1 << (kWeightShift - 1))) >> kWeightShift;
    const Masks least = rounded > 1 ? rounded : Masks{} + 1;
    return least < 0xffff ? least : Masks{} + 0xffff;
}

}  // namespace divemesh::worker
