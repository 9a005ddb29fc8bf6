#include "worker/dive/undo_paeth.hpp"

#include <algorithm>

#include "worker/base/lanes.hpp"

namespace divemesh::dive {
namespace {

using base::SignedShorts;
using Bytes = std::uint8_t __attribute__((vector_size(base::kLanes)));
static_assert(PaethRows::kNumRows == base::kLanes);

// Return the one of a, b, c (left, above, left above) that is nearest to a + b - c. Have no
// branches, which would be mispredicted on noise (as in stb_image).
int paeth(int a, int b, int c) {
    const int low = std::min(a, b);
    const int high = std::max(a, b);
    const int threshold = 3 * c - (a + b);
    const int inner = high <= threshold ? low : c;
    return threshold <= low ? high : inner;
}
DIVEMESH_INLINE_BODY SignedShorts paeth(SignedShorts a, SignedShorts b, SignedShorts c) {
    const SignedShorts low = a < b ? a : b;
    const SignedShorts high = a < b ? b : a;
    const SignedShorts threshold = 3 * c - (a + b);
    const SignedShorts inner = high <= threshold ? low : c;
    return threshold <= low ? high : inner;
}

}  // namespace

void PaethRows::undo(const std::uint8_t* filtered,
                     const std::uint8_t* above,
                     std::uint8_t* row) const {
    int left = 0;
    int left_above = 0;
    for (int u = 0; u < width_; ++u) {
        left = (filtered[u] + paeth(left, above[u], left_above)) & 0xff;
        left_above = above[u];
        row[u] = static_cast<std::uint8_t>(left);
    }
}

void PaethRows::undo_eight(const std::uint8_t* filtered,
                           std::size_t step_bytes,
                           const std::uint8_t* above,
                           std::uint8_t* row,
                           std::size_t image_step_bytes) {
    const int num_steps = width_ + kNumRows - 1;
    filtered_.resize(static_cast<std::size_t>(num_steps) * kNumRows);
    pixels_.resize(filtered_.size());
    const auto first_of = [](std::vector<std::uint8_t>& steps, std::size_t k) {
        return steps.data() + k * kNumRows + k;
    };
    for (std::size_t k = 0; k < kNumRows; ++k) {
        const std::uint8_t* from = filtered + k * step_bytes;
        std::uint8_t* to = first_of(filtered_, k);
        for (int u = 0; u < width_; ++u) to[std::ptrdiff_t{u} * kNumRows] = from[u];
    }
    SignedShorts left = {};
    SignedShorts over = {};
    for (int u = 0; u < num_steps; ++u) {
        const SignedShorts left_over = over;
        over = __builtin_shufflevector(left, left, 0, 0, 1, 2, 3, 4, 5, 6);
        over[0] = static_cast<std::int16_t>(u < width_ ? above[u] : 0);
        const std::ptrdiff_t step = std::ptrdiff_t{u} * kNumRows;
        const auto bytes = base::load_lanes<Bytes>(filtered_.data() + step);
        left = (__builtin_convertvector(bytes, SignedShorts) + paeth(left, over, left_over)) & 0xff;
        base::store(pixels_.data() + step, __builtin_convertvector(left, Bytes));
    }
    for (std::size_t k = 0; k < kNumRows; ++k) {
        const std::uint8_t* from = first_of(pixels_, k);
        std::uint8_t* to = row + k * image_step_bytes;
        for (int u = 0; u < width_; ++u) to[u] = from[std::ptrdiff_t{u} * kNumRows];
    }
}

}  // namespace divemesh::dive
