#pragma once

#include <cstdint>

#include "worker/stereo/instructions.hpp"

namespace divemesh::worker {

// Path costs of one pixel are stored with this many bytes on both sides, so that d - 1 and d + 1
// can be read at the ends of the range.
inline constexpr int kPathMargin = 32;
inline constexpr int kOutsideCost = 200;     // in those bytes: never the least
inline constexpr int kSmallStepPenalty = 6;  // P1
inline constexpr int kNumCensusBits = 32;

// One path at one pixel: costs and their least at the pixel before, and where the new ones go.
struct PathStep {
    const std::uint8_t* before = nullptr;
    std::uint8_t* here = nullptr;
    std::uint8_t before_min = 0;
    std::uint8_t step_penalty = 0;  // P2
    std::uint8_t here_min = 0;      // out
};

struct ForwardPixel {
    std::uint8_t left[4] = {};          // census of the left pixel
    const std::uint8_t* right[4] = {};  // census of the right pixels at d = 0, 1, ...
    int num_disparities = 0;            // multiple of 32
    int num_in_image = 0;               // of the disparities, those with a right pixel
    std::uint8_t* cost = nullptr;
    std::uint8_t* sum = nullptr;
    PathStep paths[4];
};

struct BackwardPixel {
    int num_disparities = 0;
    const std::uint8_t* cost = nullptr;
    std::uint8_t* sum = nullptr;
    PathStep path;
    std::uint8_t best = 0;  // out: least of sum
};

// Census distance of one pixel at all disparities, then four path steps and their sum. Sums
// saturate at 255.
using ForwardKernel = void (*)(ForwardPixel&);
// The fifth path added to the sum.
using BackwardKernel = void (*)(BackwardPixel&);
// Least of `num` values, a multiple of 32.
using LeastKernel = std::uint8_t (*)(const std::uint8_t*, int num);
// One byte plane of the census of a row: bit k tells whether the k-th neighbour is at least as
// bright as the centre.
using CensusKernel = void (*)(const std::uint8_t* center,
                              const std::uint8_t* const* neighbours,
                              int num,
                              std::uint8_t* plane);

struct SgmKernels {
    ForwardKernel forward;
    BackwardKernel backward;
    LeastKernel least;
    CensusKernel census;
};

SgmKernels sgm_kernels(Instructions instructions);

}  // namespace divemesh::worker
