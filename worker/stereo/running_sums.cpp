#include "worker/stereo/running_sums.hpp"

#include <utility>

namespace divemesh::worker {
namespace {

DIVEMESH_INLINE_BODY void exchange_body(std::int32_t* sum_,
                                        const std::int32_t* entering_,
                                        const std::int32_t* leaving_,
                                        int num) {
    std::int32_t* __restrict sum = sum_;
    const std::int32_t* __restrict entering = entering_;
    const std::int32_t* __restrict leaving = leaving_;
    for (int x = 0; x < num; ++x) sum[x] += entering[x] - leaving[x];
}

DIVEMESH_INLINE_BODY void widen_body(const std::int32_t* column_,
                                     int num,
                                     int radius,
                                     float* window_) {
    const std::int32_t* __restrict column = column_;
    float* __restrict window = window_;
    for (int x = radius; x < num - radius; ++x) {
        std::int32_t sum = 0;
        for (int i = -radius; i <= radius; ++i) sum += column[x + i];
        window[x] = static_cast<float>(sum);
    }
}

struct Kernels {
    void (*exchange)(std::int32_t*, const std::int32_t*, const std::int32_t*, int);
    void (*widen)(const std::int32_t*, int, int, float*);
};

void exchange(std::int32_t* sum, const std::int32_t* in, const std::int32_t* out, int num) {
    exchange_body(sum, in, out, num);
}
// The radii that are used, so that the inner loop has a fixed length.
DIVEMESH_INLINE_BODY void widen_fixed(const std::int32_t* column,
                                      int num,
                                      int radius,
                                      float* window) {
    if (radius == 4) return widen_body(column, num, 4, window);
    if (radius == 3) return widen_body(column, num, 3, window);
    widen_body(column, num, radius, window);
}
void widen(const std::int32_t* column, int num, int radius, float* window) {
    widen_fixed(column, num, radius, window);
}
DIVEMESH_FOR_AVX2 void exchange_avx2(std::int32_t* sum,
                                     const std::int32_t* in,
                                     const std::int32_t* out,
                                     int num) {
    exchange_body(sum, in, out, num);
}
DIVEMESH_FOR_AVX2 void widen_avx2(const std::int32_t* column, int num, int radius, float* window) {
    widen_fixed(column, num, radius, window);
}

}  // namespace

RunningSums::RunningSums(int num_terms, int width, int radius_px, Instructions instructions)
    : radius_px_(radius_px),
      instructions_(instructions),
      entering_(num_terms, Row(width, 0)),
      rows_(2 * radius_px + 1, entering_),
      columns_(entering_),
      sums_(num_terms, std::vector<float>(width, 0.0F)) {}

void RunningSums::add_row() {
    const Kernels kernels = instructions_ == Instructions::Baseline
                                ? Kernels{exchange, widen}
                                : Kernels{exchange_avx2, widen_avx2};
    auto& leaving = rows_[static_cast<std::size_t>(num_rows_) % rows_.size()];
    const int width = static_cast<int>(columns_.front().size());
    ++num_rows_;
    for (std::size_t term = 0; term < columns_.size(); ++term) {
        kernels.exchange(
            columns_[term].data(), entering_[term].data(), leaving[term].data(), width);
        std::swap(leaving[term], entering_[term]);
        if (whole()) kernels.widen(columns_[term].data(), width, radius_px_, sums_[term].data());
    }
}

}  // namespace divemesh::worker
