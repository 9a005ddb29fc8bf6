#include "worker/fusion/close_pinholes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace divemesh::fusion {
namespace {

constexpr float kMaxStep_px = 1.0F;  // of the disparity between neighbours on one surface
constexpr float kMaxSlope = 0.5F;    // of the disparity per pixel, across a hole
constexpr int kReach_px = 3;         // from a pixel of a hole to its border
constexpr int kMinDirections = 3;    // with surface on both sides
constexpr int kMaxAlike = 2;         // neighbours like a disparity that stands apart
constexpr std::array<std::array<int, 2>, 4> kDirections = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};

struct Depth {
    const cv::Mat& disparity;
    const cv::Mat& sigma;
    const cv::Mat& known;  // CV_8U, see known_with_margin()
};

// The surface at the border of a hole.
struct Border {
    float disparity_px;
    float sigma_px;
    int distance_px;
};

struct Bridge {
    float disparity_px;
    float sigma_px;
};

// Marks the disparities of a row that stand apart.
void find_apart(const cv::Mat& disparity, int row, std::uint8_t* __restrict apart) {
    const auto* above = disparity.ptr<float>(row - 1);
    const auto* here = disparity.ptr<float>(row);
    const auto* below = disparity.ptr<float>(row + 1);
    for (int x = 1; x + 1 < disparity.cols; ++x) {
        const auto alike = [d = here[x]](float other) {
            return static_cast<int>(std::abs(other - d) <= kMaxStep_px);
        };
        const int num_alike = alike(above[x - 1]) + alike(above[x]) + alike(above[x + 1]) +
                              alike(here[x - 1]) + alike(here[x + 1]) + alike(below[x - 1]) +
                              alike(below[x]) + alike(below[x + 1]);
        apart[x] = static_cast<std::uint8_t>(static_cast<int>(num_alike <= kMaxAlike) &
                                             static_cast<int>(here[x] > 0.0F));
    }
}

// Returns 255 where there is a disparity, 0 elsewhere and in a margin of kReach_px all around.
cv::Mat known_with_margin(const cv::Mat& disparity) {
    cv::Mat known(disparity.rows + 2 * kReach_px, disparity.cols + 2 * kReach_px, CV_8U);
    known.setTo(0);
    cv::Mat inner = known(cv::Rect({kReach_px, kReach_px}, disparity.size()));
    cv::compare(disparity, 0.0, inner, cv::CMP_GT);
    return known;
}

// Returns 255 if one of the next pixels in a direction is known.
int reaches(const std::uint8_t* at, std::ptrdiff_t step) {
    static_assert(kReach_px == 3);
    return at[step] | at[2 * step] | at[3 * step];
}
int reaches_both_ways(const std::uint8_t* at, std::ptrdiff_t step) {
    return reaches(at, step) & reaches(at, -step);
}

// Marks the unknown pixels of a row with known ones on both sides along at least three of the four
// directions.
void find_enclosed(const cv::Mat& known, int row, std::uint8_t* __restrict enclosed) {
    static_assert(kMinDirections == 3 && kDirections.size() == 4);
    const auto* at = known.ptr<std::uint8_t>(row + kReach_px) + kReach_px;
    const auto stride = static_cast<std::ptrdiff_t>(known.step[0]);
    const int width = known.cols - 2 * kReach_px;
    for (int x = 0; x < width; ++x, ++at) {
        const int across = reaches_both_ways(at, 1);
        const int down = reaches_both_ways(at, stride);
        const int falling = reaches_both_ways(at, stride + 1);
        const int rising = reaches_both_ways(at, stride - 1);
        const int most =
            (across & down & (falling | rising)) | (falling & rising & (across | down));
        enclosed[x] = static_cast<std::uint8_t>(most & ~*at);
    }
}

std::optional<Border> border_of(const Depth& depth, cv::Point from, int dx, int dy) {
    for (int distance = 1; distance <= kReach_px; ++distance) {
        const cv::Point at(from.x + distance * dx, from.y + distance * dy);
        if (depth.known.at<std::uint8_t>(at.y + kReach_px, at.x + kReach_px) != 0)
            return Border{depth.disparity.at<float>(at), depth.sigma.at<float>(at), distance};
    }
    return std::nullopt;
}

// Interpolates between the two borders of a hole along a direction, if they are one surface.
std::optional<Bridge> bridge(const Depth& depth, cv::Point at, int dx, int dy) {
    const auto ahead = border_of(depth, at, dx, dy);
    if (!ahead) return std::nullopt;
    const auto behind = border_of(depth, at, -dx, -dy);
    if (!behind) return std::nullopt;
    const float step = ahead->disparity_px - behind->disparity_px;
    const auto apart_px = static_cast<float>(ahead->distance_px + behind->distance_px);
    if (std::abs(step) > kMaxSlope * apart_px) return std::nullopt;
    const float share = static_cast<float>(behind->distance_px) / apart_px;
    return Bridge{behind->disparity_px + share * step, std::max(ahead->sigma_px, behind->sigma_px)};
}

std::optional<Bridge> closed(const Depth& depth, cv::Point at) {
    float sum = 0.0F;
    float min_px = std::numeric_limits<float>::max();
    float max_px = 0.0F;
    float sigma = 0.0F;
    int num = 0;
    for (const auto& [dx, dy] : kDirections) {
        const auto along = bridge(depth, at, dx, dy);
        if (!along) continue;
        sum += along->disparity_px;
        min_px = std::min(min_px, along->disparity_px);
        max_px = std::max(max_px, along->disparity_px);
        sigma = std::max(sigma, along->sigma_px);
        ++num;
    }
    if (num < kMinDirections || max_px - min_px > kMaxStep_px) return std::nullopt;
    return Bridge{sum / static_cast<float>(num), sigma};
}

}  // namespace

void close_pinholes(cv::Mat& disparity_px, cv::Mat& sigma_px) {
    cv::Mat apart(disparity_px.size(), CV_8U, cv::Scalar(0));
    for (int y = 1; y + 1 < disparity_px.rows; ++y)
        find_apart(disparity_px, y, apart.ptr<std::uint8_t>(y));
    disparity_px.setTo(0.0F, apart);
    const cv::Mat known = known_with_margin(disparity_px);
    std::vector<std::uint8_t> enclosed(static_cast<std::size_t>(disparity_px.cols));
    for (int y = 0; y < disparity_px.rows; ++y) {
        find_enclosed(known, y, enclosed.data());
        for (int x = 0; x < disparity_px.cols; ++x) {
            if (enclosed[static_cast<std::size_t>(x)] == 0) continue;
            const auto surface = closed({disparity_px, sigma_px, known}, {x, y});
            if (!surface) continue;
            disparity_px.at<float>(y, x) = surface->disparity_px;
            sigma_px.at<float>(y, x) = surface->sigma_px;
        }
    }
}

}  // namespace divemesh::fusion
