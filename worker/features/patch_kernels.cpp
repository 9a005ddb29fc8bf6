#include "worker/features/patch_kernels.hpp"

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
            base::compiled_for<make_columns>(instructions),
            base::compiled_for<compare>(instructions)};
}

}  // namespace divemesh::features
