#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "worker/base/instructions.hpp"

// The inner loops of patch alignment, in integers: grey levels are interpolated with 6 fractional
// bits and stored with 4.
namespace divemesh::features {

inline constexpr int kPatchSide_px = 16;
inline constexpr int kPatchPixels = kPatchSide_px * kPatchSide_px;
inline constexpr int kOuterSide_px = kPatchSide_px + 2;  // one more ring, for the gradients
inline constexpr int kOuterPixels = kOuterSide_px * kOuterSide_px;
inline constexpr int kGreyLevel = 16;  // scale of the stored values

// The position of a square between pixels: the pixel at or before its upper left corner, and the
// offset from there to the right and down in 1/32768 px.
struct SquarePlace {
    const std::uint8_t* corner = nullptr;
    std::ptrdiff_t step_bytes = 0;  // from row to row
    std::int16_t right = 0;
    std::int16_t below = 0;
};

// A square that is warped: its pixel (u, v) from its centre lies at `centre` + `warp` * (u, v) of
// the image, in pixels.
struct WarpedPlace {
    const std::uint8_t* image = nullptr;  // its first pixel
    std::ptrdiff_t step_bytes = 0;        // from row to row
    Eigen::Vector2d centre;
    Eigen::Matrix2d warp;
};

// A patch as the columns of a linear least-squares problem.
struct PatchColumns {
    alignas(32) std::int16_t value[kPatchPixels];  // minus `centre`
    alignas(32) std::int16_t gradient_x[kPatchPixels];
    alignas(32) std::int16_t gradient_y[kPatchPixels];
    std::int16_t centre = 0;  // mean of the patch, 6 fractional bits
};

// Sums over the patch of the products of its columns.
struct ColumnProducts {
    std::int32_t x, y, value;
    std::int32_t x_x, x_y, y_y, x_value, y_value, value_value;
};

// The same, of the columns with the values of another image, minus the same centre.
struct SeenProducts {
    std::int32_t seen;
    std::int32_t x_seen, y_seen, value_seen;
    std::uint32_t seen_seen;
};

// The kernels of one instruction set.
struct PatchKernels {
    // Reads kOuterSide_px squared values with 6 fractional bits.
    void (*read_outer)(const SquarePlace& place, std::int16_t* outer);
    // The same of a warped square, all of which must lie in the image.
    void (*read_warped)(const WarpedPlace& place, std::int16_t* outer);
    ColumnProducts (*make_columns)(const std::int16_t* outer, PatchColumns& columns);
    SeenProducts (*compare)(const PatchColumns& columns, const SquarePlace& place);
};

// Returns the kernels for an instruction set.
PatchKernels patch_kernels(base::Instructions instructions);

}  // namespace divemesh::features
