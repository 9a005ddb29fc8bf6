#include "worker/stereo/running_sums.hpp"

#include <utility>

namespace divemesh::stereo {
namespace {

DIVEMESH_INLINE_BODY void exchange(std::int32_t* sum_at,
                                   const std::int32_t* entering_at,
                                   const std::int32_t* leaving_at,
                                   int num) {
    std::int32_t* __restrict sum = sum_at;
    const std::int32_t* __restrict entering = entering_at;
    const std::int32_t* __restrict leaving = leaving_at;
    for (int x = 0; x < num; ++x) sum[x] += entering[x] - leaving[x];
}

DIVEMESH_INLINE_BODY void widen_within(const std::int32_t* column_at,
                                       int num,
                                       int radius,
                                       float* window_at) {
    const std::int32_t* __restrict column = column_at;
    float* __restrict window = window_at;
    for (int x = radius; x < num - radius; ++x) {
        std::int32_t sum = 0;
        for (int i = -radius; i <= radius; ++i) sum += column[x + i];
        window[x] = static_cast<float>(sum);
    }
}

// Calls the loop with a constant radius for the radii in use, so that its length is fixed.
DIVEMESH_INLINE_BODY void widen(const std::int32_t* column, int num, int radius, float* window) {
    if (radius == 4) return widen_within(column, num, 4, window);
    if (radius == 3) return widen_within(column, num, 3, window);
    widen_within(column, num, radius, window);
}

}  // namespace

RunningSums::RunningSums(int num_terms, int width, int radius_px, base::Instructions instructions)
    : radius_px_(radius_px),
      instructions_(instructions),
      entering_(num_terms, Row(width, 0)),
      rows_(2 * radius_px + 1, entering_),
      columns_(entering_),
      sums_(num_terms, std::vector<float>(width, 0.0F)) {}

void RunningSums::add_row() {
    const auto exchange_row = base::compiled_for<exchange>(instructions_);
    const auto widen_row = base::compiled_for<widen>(instructions_);
    auto& leaving = rows_[static_cast<std::size_t>(num_rows_) % rows_.size()];
    const int width = static_cast<int>(columns_.front().size());
    ++num_rows_;
    for (std::size_t term = 0; term < columns_.size(); ++term) {
        exchange_row(columns_[term].data(), entering_[term].data(), leaving[term].data(), width);
        std::swap(leaving[term], entering_[term]);
        if (whole()) widen_row(columns_[term].data(), width, radius_px_, sums_[term].data());
    }
}

}  // namespace divemesh::stereo
