#pragma once

#include <cstddef>
#include <cstdint>

#include "worker/base/instructions.hpp"
#include "worker/types/disparity_range.hpp"

namespace divemesh::stereo {

using types::kMaxDisparities;

inline constexpr int kOutsideCost = 210;     // of a path outside the range: never the min
inline constexpr int kSmallStepPenalty = 8;  // P1
inline constexpr int kMaxStepPenalty = 80;   // P2 where the grey value is constant
inline constexpr int kMinStepPenalty = 25;   // P2 across an edge
inline constexpr int kNumCensusBits = 32;
inline constexpr int kUniqueness_percent = 5;
inline constexpr int kMaxVectorBytes = 64;  // the kernels read this far past the end

// Costs of one path, kept from row to row: slot s holds those of one pixel, [d], and their min. A
// path overwrites the costs of its previous pixel in place if the slot is (x - y) mod (width + 1)
// for a path from above left, x from above, and (x + y) mod (width + 1) from above right. The extra
// slot separates two rows that are processed together.
struct VerticalPath {
    std::uint8_t* costs = nullptr;  // of slot 0, d = 0
    std::uint8_t* min_cost = nullptr;
    int first_slot = 0;  // the slot of x = 0
};

// One row as input and output of the forward kernel.
struct ForwardRow {
    int width = 0;
    int first_x = 0;  // of the row in the image
    int first_disparity = 0;
    int num_disparities = 0;           // multiple of 32; [d] has a stride of whole vectors
    const std::uint8_t* left[4] = {};  // byte planes of the census
    // [width - 1 - x], starting at the first disparity; readable past the end
    const std::uint8_t* right_reversed[4] = {};
    // P2 by x, for the paths from above left, above, above right, left.
    const std::uint8_t* penalty[4] = {};
    VerticalPath above[3];
    std::uint8_t* cost = nullptr;  // out, [x][d]
    std::uint8_t* sum = nullptr;   // out, over the four paths
};

// One row as input and output of the backward kernel.
struct BackwardRow {
    int width = 0;
    int num_disparities = 0;
    const std::uint8_t* penalty = nullptr;
    const std::uint8_t* cost = nullptr;
    const std::uint8_t* sum = nullptr;
    // Outputs by x:
    std::uint8_t* min_cost = nullptr;  // of the sums
    std::int16_t* min_at = nullptr;    // the first d with min_cost, from the first disparity on
    std::uint8_t* is_unique = nullptr;
    std::uint8_t* lower = nullptr;  // the sums at d - 1 and d + 1, if unique
    std::uint8_t* upper = nullptr;
};

// The winners of a backward row, confirmed or not.
struct WinnerRow {
    int width = 0;
    const std::uint8_t* min_cost = nullptr;
    const std::int16_t* min_at = nullptr;  // disparities
    const std::uint8_t* lower = nullptr;
    const std::uint8_t* upper = nullptr;
    const std::uint8_t* is_confirmed = nullptr;
};

// Computes the census distance of one row, or of two consecutive rows, at all disparities, then the
// steps of four paths and their sum. Sums saturate at 255.
using ForwardKernel = void (*)(const ForwardRow* rows, int num_rows);
// Adds the fifth path to the sum, and finds the min.
using BackwardKernel = void (*)(const BackwardRow* rows, int num_rows);
// Computes sub-pixel disparities; negative: unconfirmed, in whole pixels; 0: the match lies outside
// the image.
using SubpixelKernel = void (*)(const WinnerRow& row, float* disparity_px);
// Computes one byte plane of a row's census: bit k is 1 if the k-th neighbour is at least as bright
// as the centre plus `tolerance` (k even) or minus it (k odd). Opposite neighbours differ in k by
// an odd number, so differences within the tolerance give the same bits everywhere and noise costs
// nothing.
using CensusKernel = void (*)(const std::uint8_t* center,
                              const std::uint8_t* const* neighbours,
                              int num,
                              int tolerance,
                              std::uint8_t* plane);

// Computes P2 for `num` pairs of neighbours from their grey values.
using PenaltyKernel = void (*)(const std::uint8_t* a,
                               const std::uint8_t* b,
                               int num,
                               std::uint8_t* penalty);

// The kernels of one instruction set.
struct SgmKernels {
    ForwardKernel forward;
    BackwardKernel backward;
    SubpixelKernel place;
    CensusKernel census;
    PenaltyKernel penalties;
    int vector_bytes;
};

// Returns the kernels for an instruction set.
SgmKernels sgm_kernels(base::Instructions instructions);

}  // namespace divemesh::stereo
