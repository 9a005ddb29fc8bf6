#include "worker/stereo/search_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace divemesh::stereo {
namespace {

constexpr int kTileWidth_px = 384;
constexpr int kTileHeight_px = 256;
constexpr int kSurroundings_px = 32;
constexpr double kMinKnown = 0.25;      // share of a tile at half the size
constexpr double kFewOutliers = 0.002;  // share of the known disparities at each end
constexpr float kMargin_px = 12.0F;     // beyond the disparities of the half size
constexpr float kMarginShare = 0.06F;   // of such a disparity
constexpr int kStep_px = 64;            // of the number of disparities
constexpr double kWorthwhile = 0.8;     // of the cost without tiles

// Returns the disparities within a part of the image at half the size; none if few are known.
std::vector<float> disparities_within(const cv::Mat& half_disparity_px, const cv::Rect& part) {
    const cv::Rect half =
        cv::Rect(part.x / 2, part.y / 2, (part.width + 1) / 2, (part.height + 1) / 2) &
        cv::Rect({}, half_disparity_px.size());
    std::vector<float> known;
    known.reserve(static_cast<std::size_t>(half.area()));
    for (int y = half.y; y < half.br().y; ++y) {
        const float* row = half_disparity_px.ptr<float>(y);
        for (int x = half.x; x < half.br().x; ++x)
            if (row[x] > 0.0F) known.push_back(2.0F * row[x]);
    }
    if (static_cast<double>(known.size()) < kMinKnown * half.area()) return {};
    return known;
}

types::DisparityRange range_of(std::vector<float> disparities, const types::DisparityRange& whole) {
    if (disparities.empty()) return whole;
    const auto few =
        static_cast<std::ptrdiff_t>(kFewOutliers * static_cast<double>(disparities.size()));
    const auto low_at = disparities.begin() + few;
    const auto high_at = disparities.end() - 1 - few;
    std::nth_element(disparities.begin(), low_at, disparities.end());
    const float low = *low_at;
    std::nth_element(low_at, high_at, disparities.end());
    const float high = *high_at;
    const int end_of_whole = whole.first_px + whole.num_px;
    const int first = std::max(whole.first_px,
                               static_cast<int>(std::floor(low - kMargin_px - kMarginShare * low)));
    const int end = std::min(
        end_of_whole, static_cast<int>(std::ceil(high + kMargin_px + kMarginShare * high)) + 1);
    const int num = (std::max(1, end - first) + kStep_px - 1) / kStep_px * kStep_px;
    if (num >= whole.num_px) return whole;
    // Rounding up extends the range equally at both ends.
    const int earlier = first - (num - (end - first)) / 2;
    return {std::clamp(earlier, whole.first_px, end_of_whole - num), num};
}

int num_parts(int length_px, int part_px) {
    return std::max(1, (length_px + part_px / 2) / part_px);
}

}  // namespace

cv::Rect with_surroundings(const cv::Rect& part, cv::Size size) {
    return cv::Rect(part.x - kSurroundings_px,
                    part.y - kSurroundings_px,
                    part.width + 2 * kSurroundings_px,
                    part.height + 2 * kSurroundings_px) &
           cv::Rect({}, size);
}

std::vector<SearchTile> search_tiles(const cv::Mat& half_disparity_px,
                                     cv::Size size,
                                     const types::DisparityRange& range) {
    const int num_columns = num_parts(size.width, kTileWidth_px);
    const int num_rows = num_parts(size.height, kTileHeight_px);
    std::vector<SearchTile> tiles;
    double cost = 0.0;
    for (int j = 0; j < num_rows; ++j)
        for (int i = 0; i < num_columns; ++i) {
            const cv::Point begin(i * size.width / num_columns, j * size.height / num_rows);
            const cv::Point end((i + 1) * size.width / num_columns,
                                (j + 1) * size.height / num_rows);
            const cv::Rect part(begin, end);
            const cv::Rect seen = with_surroundings(part, size);
            tiles.push_back({part, range_of(disparities_within(half_disparity_px, seen), range)});
            cost += static_cast<double>(seen.area()) * tiles.back().range.num_px;
        }
    if (cost < kWorthwhile * static_cast<double>(size.area()) * range.num_px) return tiles;
    return {{cv::Rect({}, size), range}};
}

}  // namespace divemesh::stereo
