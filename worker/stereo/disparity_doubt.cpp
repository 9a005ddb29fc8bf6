#include "worker/stereo/disparity_doubt.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "worker/base/lanes.hpp"
#include "worker/stereo/running_sums.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kRadius_px = 4;  // of windows as wide as those of matching and refinement
constexpr int kNumPixels = (2 * kRadius_px + 1) * (2 * kRadius_px + 1);
constexpr float kMaxStep_px = 3.0F;    // within 3 x 3 pixels of one surface
constexpr float kFullDoubt_px = 2.5F;  // sigma where all winners around are doubtful
constexpr float kDoubtPerPixel_px = kFullDoubt_px / static_cast<float>(kNumPixels);

// Min and max of |winner| over three rows, by column, with one more on both sides.
struct Extremes {
    explicit Extremes(int width)
        : min_px(static_cast<std::size_t>(width) + 2),
          max_px(static_cast<std::size_t>(width) + 2) {}
    std::vector<float> min_px;
    std::vector<float> max_px;
};

// Sets `doubtful` to 1 where a winner of the middle row is unconfirmed or beside a step, else to 0.
DIVEMESH_INLINE_BODY void mark_doubtful(const float* const (&rows)[3],
                                        int width,
                                        Extremes& extremes,
                                        std::int32_t* doubtful_at) {
    const float* __restrict above = rows[0];
    const float* __restrict row = rows[1];
    const float* __restrict below = rows[2];
    float* __restrict min_px = extremes.min_px.data();
    float* __restrict max_px = extremes.max_px.data();
    std::int32_t* __restrict doubtful = doubtful_at;
    for (int x = 0; x < width; ++x) {
        const float a = std::abs(above[x]);
        const float b = std::abs(row[x]);
        const float c = std::abs(below[x]);
        const float lower = a < b ? a : b;
        const float upper = a < b ? b : a;
        min_px[x + 1] = lower < c ? lower : c;
        max_px[x + 1] = upper < c ? c : upper;
    }
    min_px[0] = min_px[1];
    max_px[0] = max_px[1];
    min_px[width + 1] = min_px[width];
    max_px[width + 1] = max_px[width];
    for (int x = 0; x < width; ++x) {
        float lower = min_px[x] < min_px[x + 1] ? min_px[x] : min_px[x + 1];
        lower = lower < min_px[x + 2] ? lower : min_px[x + 2];
        float upper = max_px[x] < max_px[x + 1] ? max_px[x + 1] : max_px[x];
        upper = upper < max_px[x + 2] ? max_px[x + 2] : upper;
        doubtful[x] = static_cast<std::int32_t>(upper - lower > kMaxStep_px) |
                      static_cast<std::int32_t>(row[x] <= 0.0F);
    }
}

// Raises the sigmas of a row by the numbers of doubtful pixels in the windows around them.
DIVEMESH_INLINE_BODY void raise_row(const float* num_doubtful, int width, float* sigmas) {
    int x = 0;
    for (; x + base::kLanes <= width; x += base::kLanes) {
        const base::Floats sigma = base::load(sigmas + x);
        const base::Floats doubt = kDoubtPerPixel_px * base::load(num_doubtful + x);
        base::store(sigmas + x, base::square_root(sigma * sigma + doubt * doubt));
    }
    for (; x < width; ++x) {
        const float doubt = kDoubtPerPixel_px * num_doubtful[x];
        sigmas[x] = std::sqrt(sigmas[x] * sigmas[x] + doubt * doubt);
    }
}

// Returns the pixel that stands for one beyond the border: its mirror image, the border's own not
// repeated.
int mirrored(int i, int num) { return cv::borderInterpolate(i, num, cv::BORDER_REFLECT_101); }

}  // namespace

void add_doubt(const cv::Mat& winners_px, cv::Mat& sigma_px, base::Instructions instructions) {
    const auto mark = base::compiled_for<mark_doubtful>(instructions);
    const auto raise = base::compiled_for<raise_row>(instructions);
    const int width = winners_px.cols;
    const int height = winners_px.rows;
    Extremes extremes(width);
    RunningSums window(1, width + 2 * kRadius_px, kRadius_px, instructions);
    for (int y = -kRadius_px; y < height + kRadius_px; ++y) {
        const int row = mirrored(y, height);
        std::int32_t* doubtful = window.next(0).data() + kRadius_px;
        const float* const rows[3] = {winners_px.ptr<float>(std::max(row - 1, 0)),
                                      winners_px.ptr<float>(row),
                                      winners_px.ptr<float>(std::min(row + 1, height - 1))};
        mark(rows, width, extremes, doubtful);
        for (int i = 1; i <= kRadius_px; ++i) {
            doubtful[-i] = doubtful[mirrored(-i, width)];
            doubtful[width - 1 + i] = doubtful[mirrored(width - 1 + i, width)];
        }
        window.add_row();
        if (window.whole())
            raise(window.sums(0).data() + kRadius_px, width, sigma_px.ptr<float>(y - kRadius_px));
    }
}

}  // namespace divemesh::stereo
