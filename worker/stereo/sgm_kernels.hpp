#pragma once

#include <cstddef>
#include <cstdint>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

inline constexpr int kOutsideCost = 200;     // of a path beside the range: never the least
inline constexpr int kSmallStepPenalty = 6;  // P1
inline constexpr int kMaxStepPenalty = 60;   // P2 on even ground
inline constexpr int kMinStepPenalty = 20;   // P2 across an edge
inline constexpr int kNumCensusBits = 32;
inline constexpr int kUniqueness_percent = 5;
inline constexpr int kMaxDisparities = 512;
inline constexpr int kMaxVectorBytes = 64;  // bytes: the kernels read so far past the end

// Costs of one path, kept from row to row: slot s holds those of one pixel, [d], and their least.
// A path that comes from above left finds the pixel before it where its own costs go when the slot
// is (x - y) mod (width + 1); from above, x; from above right, (x + y) mod (width + 1). The slot
// too many keeps a row that goes along with the one above it out of that one's way.
struct VerticalPath {
    std::uint8_t* costs = nullptr;  // of slot 0 at d = 0
    std::uint8_t* min_cost = nullptr;
    int first_slot = 0;  // of x = 0
};

struct ForwardRow {
    int width = 0;
    int first_disparity = 0;
    int num_disparities = 0;           // multiple of 32; [d] has a stride of whole vectors
    const std::uint8_t* left[4] = {};  // byte planes of the census
    // [width - 1 - x], from the first disparity on; readable past the end
    const std::uint8_t* right_reversed[4] = {};
    const std::uint8_t* penalty[4] = {};  // P2 by x: from above left, above, above right, left
    VerticalPath above[3];
    std::uint8_t* cost = nullptr;  // out, [x][d]
    std::uint8_t* sum = nullptr;   // out, of the four paths
};

struct BackwardRow {
    int width = 0;
    int num_disparities = 0;
    const std::uint8_t* penalty = nullptr;
    const std::uint8_t* cost = nullptr;
    const std::uint8_t* sum = nullptr;
    // Out, by x:
    std::uint8_t* min_cost = nullptr;  // of the sums
    std::int16_t* min_at = nullptr;    // the first d that has it
    std::uint8_t* is_unique = nullptr;
    std::uint8_t* lower = nullptr;  // where unique the sums at d - 1 and d + 1
    std::uint8_t* upper = nullptr;
};

// What a way back found, confirmed or not.
struct WinnerRow {
    int width = 0;
    int first_disparity = 0;
    const std::uint8_t* min_cost = nullptr;
    const std::int16_t* min_at = nullptr;
    const std::uint8_t* lower = nullptr;
    const std::uint8_t* upper = nullptr;
    const std::uint8_t* is_confirmed = nullptr;
};

// Census distance of one row, or of two that follow each other, at all disparities, then four path
// steps and their sum. Sums saturate at 255.
using ForwardKernel = void (*)(const ForwardRow* rows, int num_rows);
// The fifth path added to the sum, and the least of it.
using BackwardKernel = void (*)(const BackwardRow* rows, int num_rows);
// To fractions of a pixel; negative: not confirmed, to the pixel; 0: from outside of the picture.
using SubpixelKernel = void (*)(const WinnerRow& row, float* disparity_px);
// One byte plane of the census of a row: bit k tells whether the k-th neighbour is at least as
// bright as the centre.
using CensusKernel = void (*)(const std::uint8_t* center,
                              const std::uint8_t* const* neighbours,
                              int num,
                              std::uint8_t* plane);

// P2 of `num` pairs of neighbours by their grey values.
using PenaltyKernel = void (*)(const std::uint8_t* a,
                               const std::uint8_t* b,
                               int num,
                               std::uint8_t* penalty);

struct SgmKernels {
    ForwardKernel forward;
    BackwardKernel backward;
    SubpixelKernel place;
    CensusKernel census;
    PenaltyKernel penalties;
    int vector_bytes;
};

SgmKernels sgm_kernels(base::Instructions instructions);

}  // namespace divemesh::stereo
