#include "worker/stereo/disparity_search_range.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::stereo {
namespace {

constexpr int kStep_px = 64;
constexpr int kMinFeatures = 50;   // fewer do not represent the frame
constexpr double kFarther = 0.75;  // times a feature's disparity
constexpr double kNearer = 1.33;
constexpr double kMatcherError_px = 2.0;  // winners at the ends of the range are rejected

}  // namespace

types::DisparityRange disparity_search_range(const types::Features& features,
                                             int num_disparities_px,
                                             int width_px) {
    const int limit_px = types::max_disparities_px(num_disparities_px, width_px);
    double min_disparity = limit_px;
    double largest = 0.0;
    int num_features = 0;
    for (const types::Feature& feature : features) {
        if (!types::has_depth(feature)) continue;
        min_disparity = std::min(min_disparity, feature.disparity_px);
        largest = std::max(largest, feature.disparity_px);
        ++num_features;
    }
    if (num_features < kMinFeatures) return {0, num_disparities_px};
    const int first =
        std::max(0, static_cast<int>(std::floor(kFarther * min_disparity - kMatcherError_px)));
    const int end = static_cast<int>(std::ceil(kNearer * largest + kMatcherError_px)) + 1;
    const int num = (end - first + kStep_px - 1) / kStep_px * kStep_px;
    if (num >= limit_px) return {0, limit_px};
    // Rounding up extends the range equally at both ends.
    const int earlier = first - (num - (end - first)) / 2;
    return {std::clamp(earlier, 0, limit_px - num), num};
}

}  // namespace divemesh::stereo
