#include "worker/features/patch_kernels.hpp"

#include <cstring>

namespace divemesh::features {
namespace {

using Value = std::int16_t;

DIVEMESH_INLINE_BODY Value upper_half_of_product(Value a, Value b) {
    return static_cast<Value>((std::int32_t{a} * std::int32_t{b}) >> 16);
}

// Reads a row interpolated between columns, 6 fractional bits.
template <int kSide>
DIVEMESH_INLINE_BODY void read_row(const std::uint8_t* pixels, Value right, Value* __restrict row) {
    for (int u = 0; u < kSide; ++u) {
        const auto difference = static_cast<Value>((pixels[u + 1] - pixels[u]) * 128);
        row[u] = static_cast<Value>((pixels[u] << 6) + upper_half_of_product(difference, right));
    }
}

template <int kSide>
DIVEMESH_INLINE_BODY void read_square(const SquarePlace& place, Value* __restrict square) {
    Value rows[2][kSide];
    read_row<kSide>(place.corner, place.right, rows[0]);
    for (int v = 0; v < kSide; ++v) {
        const Value* above = rows[v % 2];
        Value* below = rows[(v + 1) % 2];
        read_row<kSide>(place.corner + (v + 1) * place.step_bytes, place.right, below);
        for (int u = 0; u < kSide; ++u) {
            const auto difference = static_cast<Value>((below[u] - above[u]) * 2);
            square[v * kSide + u] =
                static_cast<Value>(above[u] + upper_half_of_product(difference, place.below));
        }
    }
}

// Interpolates in double precision, in three loops, so that all but the reading of the pixels
// becomes vectors.
DIVEMESH_INLINE_BODY void read_warped(const WarpedPlace& place, Value* __restrict outer) {
    constexpr double kHalf = 0.5 * (kOuterSide_px - 1);
    double right[kOuterPixels];
    double below[kOuterPixels];
    std::int32_t offsets[kOuterPixels];  // of the pixel at or before, from the image's first
    const auto step = static_cast<std::int32_t>(place.step_bytes);
    for (int v = 0; v < kOuterSide_px; ++v)
        for (int u = 0; u < kOuterSide_px; ++u) {
            const double from_x = u - kHalf;
            const double from_y = v - kHalf;
            const double x =
                place.centre.x() + (place.warp(0, 0) * from_x + place.warp(0, 1) * from_y);
            const double y =
                place.centre.y() + (place.warp(1, 0) * from_x + place.warp(1, 1) * from_y);
            const auto column = static_cast<std::int32_t>(x);
            const auto row = static_cast<std::int32_t>(y);
            const int i = v * kOuterSide_px + u;
            right[i] = x - column;
            below[i] = y - row;
            offsets[i] = row * step + column;
        }
    std::uint16_t above[kOuterPixels];  // two pixels each
    std::uint16_t under[kOuterPixels];
    for (int i = 0; i < kOuterPixels; ++i) {
        const std::uint8_t* pixels = place.image + offsets[i];
        std::memcpy(&above[i], pixels, sizeof above[i]);
        std::memcpy(&under[i], pixels + step, sizeof under[i]);
    }
    constexpr double kSixBits = 64.0;
    for (int i = 0; i < kOuterPixels; ++i) {
        const auto first = [](std::uint16_t two) { return two & 0xff; };
        const auto second = [](std::uint16_t two) { return two >> 8; };
        const double upper = first(above[i]) + right[i] * (second(above[i]) - first(above[i]));
        const double lower = first(under[i]) + right[i] * (second(under[i]) - first(under[i]));
        outer[i] = static_cast<Value>(
            static_cast<std::int32_t>(kSixBits * (upper + below[i] * (lower - upper))));
    }
}

DIVEMESH_INLINE_BODY ColumnProducts make_columns(const Value* __restrict outer,
                                                 PatchColumns& columns) {
    std::int32_t sum = 0;
    for (int v = 1; v <= kPatchSide_px; ++v)
        for (int u = 1; u <= kPatchSide_px; ++u) sum += outer[v * kOuterSide_px + u];
    columns.centre = static_cast<Value>(sum / kPatchPixels);
    Value* __restrict value = columns.value;
    Value* __restrict x = columns.gradient_x;
    Value* __restrict y = columns.gradient_y;
    for (int v = 0; v < kPatchSide_px; ++v) {
        const Value* here = &outer[(v + 1) * kOuterSide_px + 1];
        for (int u = 0; u < kPatchSide_px; ++u) {
            const int i = v * kPatchSide_px + u;
            value[i] = static_cast<Value>((here[u] - columns.centre) >> 2);
            x[i] = static_cast<Value>((here[u + 1] - here[u - 1]) >> 3);
            y[i] = static_cast<Value>((here[u + kOuterSide_px] - here[u - kOuterSide_px]) >> 3);
        }
    }
    ColumnProducts sums{};
    for (int i = 0; i < kPatchPixels; ++i) {
        sums.x += x[i];
        sums.y += y[i];
        sums.value += value[i];
        sums.x_x += std::int32_t{x[i]} * x[i];
        sums.x_y += std::int32_t{x[i]} * y[i];
        sums.y_y += std::int32_t{y[i]} * y[i];
        sums.x_value += std::int32_t{x[i]} * value[i];
        sums.y_value += std::int32_t{y[i]} * value[i];
        sums.value_value += std::int32_t{value[i]} * value[i];
    }
    return sums;
}

DIVEMESH_INLINE_BODY SeenProducts compare(const PatchColumns& columns, const SquarePlace& place) {
    Value seen[kPatchPixels];
    read_square<kPatchSide_px>(place, seen);
    const Value* __restrict value = columns.value;
    const Value* __restrict x = columns.gradient_x;
    const Value* __restrict y = columns.gradient_y;
    for (int i = 0; i < kPatchPixels; ++i)
        seen[i] = static_cast<Value>((seen[i] - columns.centre) >> 2);
    SeenProducts sums{};
    for (int half = 0; half < 2; ++half) {  // squares of a whole patch may exceed 31 bits
        std::int32_t squares = 0;
        for (int i = half * kPatchPixels / 2; i < (half + 1) * kPatchPixels / 2; ++i) {
            sums.seen += seen[i];
            sums.x_seen += std::int32_t{x[i]} * seen[i];
            sums.y_seen += std::int32_t{y[i]} * seen[i];
            sums.value_seen += std::int32_t{value[i]} * seen[i];
            squares += std::int32_t{seen[i]} * seen[i];
        }
        sums.seen_seen += static_cast<std::uint32_t>(squares);
    }
    return sums;
}

}  // namespace

PatchKernels patch_kernels(base::Instructions instructions) {
    return {base::compiled_for<read_square<kOuterSide_px>>(instructions),
            base::compiled_for<read_warped>(instructions),
            base::compiled_for<make_columns>(instructions),
            base::compiled_for<compare>(instructions)};
}

}  // namespace divemesh::features
