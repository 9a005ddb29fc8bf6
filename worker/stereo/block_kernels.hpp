#pragma once

#include <cstdint>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

// The inner loops of block matching over the disparities of one pixel; `num` is a multiple of 32.
struct BlockKernels {
    // cost[d] += sign * |left - right_reversed[d]|
    void (*accumulate)(std::uint16_t* cost,
                       std::uint8_t left,
                       const std::uint8_t* right_reversed,
                       int num,
                       int sign);
    // cost[d] += entering[d] - leaving[d]
    void (*slide)(std::uint16_t* cost,
                  const std::uint16_t* entering,
                  const std::uint16_t* leaving,
                  int num);
    // Returns the min of cost.
    std::uint16_t (*min_cost)(const std::uint16_t* cost, int num);
    // Returns the first index of `value` in cost.
    int (*find)(const std::uint16_t* cost, std::uint16_t value, int num);
};

// Returns the kernels for an instruction set.
BlockKernels block_kernels(base::Instructions instructions);

}  // namespace divemesh::stereo
