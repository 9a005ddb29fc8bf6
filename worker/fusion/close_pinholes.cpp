#include "worker/fusion/close_pinholes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>

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

std::optional<Border> border_of(const Depth& depth, cv::Point from, int dx, int dy) {
    for (int distance = 1; distance <= kReach_px; ++distance) {
        const cv::Point at(from.x + distance * dx, from.y + distance * dy);
        if (at.x < 0 || at.y < 0 || at.x >= depth.disparity.cols || at.y >= depth.disparity.rows)
            break;
        if (const float d = depth.disparity.at<float>(at); d > 0.0F)
            return Border{d, depth.sigma.at<float>(at), distance};
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
    const cv::Mat known = disparity_px.clone();
    for (int y = 0; y < known.rows; ++y)
        for (int x = 0; x < known.cols; ++x) {
            if (known.at<float>(y, x) > 0.0F) continue;
            const auto surface = closed({known, sigma_px}, {x, y});
            if (!surface) continue;
            disparity_px.at<float>(y, x) = surface->disparity_px;
            sigma_px.at<float>(y, x) = surface->sigma_px;
        }
}

}  // namespace divemesh::fusion
