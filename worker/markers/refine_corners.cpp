#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "worker/markers/find_tags.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::markers {
namespace {

constexpr double kMinEdge_px = 12.0;
// Share of an edge that is skipped at both ends, where the adjacent edge interferes.
constexpr double kCornerShare = 0.12;
constexpr double kStep_px = 0.25;  // across an edge
constexpr double kMaxDistance_px = 4.0;
constexpr int kRounds = 3;

struct Line {
    Eigen::Vector2d point;
    Eigen::Vector2d direction;  // unit
};

double brightness(const cv::Mat& image, const Eigen::Vector2d& pixel) {
    const auto u = static_cast<int>(std::floor(pixel.x()));
    const auto v = static_cast<int>(std::floor(pixel.y()));
    const double right = pixel.x() - u;
    const double down = pixel.y() - v;
    const std::uint8_t* above = image.ptr<std::uint8_t>(v) + u;
    const std::uint8_t* below = image.ptr<std::uint8_t>(v + 1) + u;
    return (1.0 - down) * ((1.0 - right) * above[0] + right * above[1]) +
           down * ((1.0 - right) * below[0] + right * below[1]);
}

bool is_inside(const cv::Mat& image, const Eigen::Vector2d& pixel) {
    return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() < image.cols - 1 &&
           pixel.y() < image.rows - 1;
}

// Returns the offset from `middle` along `outward` at which the image changes most; `rising`: from
// dark to bright.
std::optional<double> edge_offset_px(const cv::Mat& image,
                                     const Eigen::Vector2d& middle,
                                     const Eigen::Vector2d& outward,
                                     double reach_px,
                                     bool rising) {
    if (!is_inside(image, middle - (reach_px + kStep_px) * outward) ||
        !is_inside(image, middle + (reach_px + kStep_px) * outward))
        return std::nullopt;
    const double sign = rising ? 1.0 : -1.0;
    double sum = 0.0;
    double moment = 0.0;
    double before = brightness(image, middle - reach_px * outward);
    const auto num_steps = static_cast<int>(std::floor(2.0 * reach_px / kStep_px));
    for (int i = 1; i <= num_steps; ++i) {
        const double t = -reach_px + i * kStep_px;
        const double here = brightness(image, middle + t * outward);
        const double slope = std::max(0.0, sign * (here - before));
        sum += slope;
        moment += slope * (t - 0.5 * kStep_px);
        before = here;
    }
    constexpr double kMinContrast = 8.0;  // grey levels
    if (sum < kMinContrast) return std::nullopt;
    return moment / sum;
}

Line line_through(const std::vector<Eigen::Vector2d>& points) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const auto& point : points) mean += point;
    mean /= static_cast<double>(points.size());
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const auto& point : points) spread += (point - mean) * (point - mean).transpose();
    const double angle = 0.5 * std::atan2(2.0 * spread(0, 1), spread(0, 0) - spread(1, 1));
    return {mean, {std::cos(angle), std::sin(angle)}};
}

double distance_px(const Line& line, const Eigen::Vector2d& point) {
    const Eigen::Vector2d way = point - line.point;
    return std::abs(way.x() * line.direction.y() - way.y() * line.direction.x());
}

// Fits a line by least squares, then again without outliers such as dirt and snow.
std::optional<Line> robust_line(std::vector<Eigen::Vector2d> points, std::size_t num_asked) {
    const std::size_t num_needed = std::max<std::size_t>(4, num_asked / 2);
    if (points.size() < num_needed) return std::nullopt;
    for (int round = 0; round < 2; ++round) {
        const Line line = line_through(points);
        std::vector<double> distances;
        distances.reserve(points.size());
        for (const auto& point : points) distances.push_back(distance_px(line, point));
        const double max_px = std::max(0.2, 3.0 * stats::upper_median(std::move(distances)));
        std::erase_if(points, [&](const auto& point) { return distance_px(line, point) > max_px; });
        if (points.size() < num_needed) return std::nullopt;
    }
    return line_through(points);
}

std::optional<Line> fit_edge(const cv::Mat& image,
                             const Eigen::Vector2d& begin,
                             const Eigen::Vector2d& end,
                             double reach_px,
                             bool rising) {
    const Eigen::Vector2d along = end - begin;
    // Corners are counter-clockwise as the tag is read, with v pointing down in the image: outward
    // is to the right of the direction of travel.
    const Eigen::Vector2d outward = Eigen::Vector2d(-along.y(), along.x()).normalized();
    const auto num_samples = static_cast<std::size_t>(std::clamp(along.norm(), kMinEdge_px, 64.0));
    std::vector<Eigen::Vector2d> points;
    for (std::size_t i = 0; i < num_samples; ++i) {
        const double share = kCornerShare + (1.0 - 2.0 * kCornerShare) *
                                                (static_cast<double>(i) + 0.5) /
                                                static_cast<double>(num_samples);
        const Eigen::Vector2d middle = begin + share * along;
        if (const auto offset = edge_offset_px(image, middle, outward, reach_px, rising))
            points.emplace_back(middle + *offset * outward);
    }
    return robust_line(std::move(points), num_samples);
}

std::optional<Eigen::Vector2d> crossing(const Line& a, const Line& b) {
    Eigen::Matrix2d A;
    A << a.direction, -b.direction;
    if (std::abs(A.determinant()) < 0.1) return std::nullopt;
    return a.point + (A.inverse() * (b.point - a.point)).x() * a.direction;
}

}  // namespace

void refine_corners(const cv::Mat& image, const TagLayout& layout, Tag& tag) {
    std::array<Eigen::Vector2d, dive::kNumTagCorners> corners = tag.corners_px;
    double shortest = (corners[3] - corners[0]).norm();
    for (std::size_t i = 0; i + 1 < dive::kNumTagCorners; ++i)
        shortest = std::min(shortest, (corners[i + 1] - corners[i]).norm());
    if (shortest < kMinEdge_px) return;
    const double reach_px = std::min(kMaxDistance_px, 0.6 * shortest / layout.size_cells);
    for (int round = 0; round < kRounds; ++round) {
        std::array<std::optional<Line>, dive::kNumTagCorners>
            edges;  // from each corner to the next
        for (std::size_t i = 0; i < dive::kNumTagCorners; ++i)
            edges[i] = fit_edge(image,
                                corners[i],
                                corners[(i + 1) % dive::kNumTagCorners],
                                reach_px,
                                !layout.white_within);
        for (std::size_t i = 0; i < dive::kNumTagCorners; ++i) {
            const auto& before = edges[(i + dive::kNumTagCorners - 1) % dive::kNumTagCorners];
            if (!before || !edges[i]) return;
            const auto corner = crossing(*before, *edges[i]);
            if (!corner || (*corner - tag.corners_px[i]).norm() > reach_px) return;
            corners[i] = *corner;
        }
    }
    tag.corners_px = corners;
}

}  // namespace divemesh::markers
