#include "worker/stereo/speckles.hpp"

#include <cmath>
#include <cstdint>
#include <vector>

namespace divemesh::worker {
namespace {

// Disjoint sets over the pixels, path halving; the root is the first pixel of the set.
class PixelSets {
public:
    explicit PixelSets(std::size_t num) : parent_(num) {
        for (std::size_t i = 0; i < num; ++i) parent_[i] = static_cast<std::int32_t>(i);
    }
    std::int32_t root(std::int32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::int32_t a, std::int32_t b) {
        a = root(a);
        b = root(b);
        if (a < b) parent_[b] = a;
        if (b < a) parent_[a] = b;
    }

private:
    std::vector<std::int32_t> parent_;
};

}  // namespace

void remove_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px) {
    const int width = disparity_px.cols;
    PixelSets sets(disparity_px.total());
    for (int y = 0; y < disparity_px.rows; ++y) {
        const float* row = disparity_px.ptr<float>(y);
        const float* above = y > 0 ? disparity_px.ptr<float>(y - 1) : nullptr;
        for (int x = 0; x < width; ++x) {
            if (row[x] <= 0.0F) continue;
            const std::int32_t i = y * width + x;
            if (x > 0 && row[x - 1] > 0.0F && std::abs(row[x - 1] - row[x]) <= max_step_px)
                sets.join(i - 1, i);
            if (above != nullptr && above[x] > 0.0F && std::abs(above[x] - row[x]) <= max_step_px)
                sets.join(i - width, i);
        }
    }
    std::vector<std::int32_t> size(disparity_px.total(), 0);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(size.size()); ++i) ++size[sets.root(i)];
    for (int y = 0; y < disparity_px.rows; ++y) {
        float* row = disparity_px.ptr<float>(y);
        for (int x = 0; x < width; ++x)
            if (row[x] > 0.0F && size[sets.root(y * width + x)] < min_pixels) row[x] = 0.0F;
    }
}

}  // namespace divemesh::worker
