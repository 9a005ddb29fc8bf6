#include "worker/features/described_keypoints.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>

#include "worker/features/corner_scores.hpp"
#include "worker/types/disparity_range.hpp"

namespace divemesh::features {
namespace {

constexpr std::size_t kMaxKeypoints = 500;
constexpr int kDescribedSize_px = 720;
constexpr int kNumLevels = 4;
constexpr double kLevelScale = 1.4;
constexpr int kCell_px = 36;    // one corner per cell on every level
constexpr int kRadius_px = 15;  // of the descriptor's patch
constexpr int kBorder_px = kRadius_px + 2;
constexpr int kNumDirections = 64;

struct Test {
    std::array<int, 4> offset;  // x, y of the first and of the second pixel
};
using Tests = std::array<Test, 256>;

// Returns the tests rotated to each of the kNumDirections directions.
std::vector<Tests> turned_tests() {
    std::mt19937_64 random(20070);
    // Gaussian by the central limit theorem: the same numbers with every standard library.
    const auto draw = [&] {
        double sum = -6.0;
        for (int i = 0; i < 12; ++i) sum += static_cast<double>(random() >> 11) * 0x1.0p-53;
        return sum * (2.0 * kRadius_px + 1.0) / 5.0;
    };
    const auto draw_point = [&] {
        std::array<double, 2> point{};
        do {
            point = {draw(), draw()};
        } while (std::hypot(point[0], point[1]) > kRadius_px - 1);
        return point;
    };
    std::vector<Tests> directions(kNumDirections);
    for (std::size_t i = 0; i < Tests{}.size(); ++i) {
        const std::array<double, 2> a = draw_point();
        const std::array<double, 2> b = draw_point();
        for (std::size_t k = 0; k < kNumDirections; ++k) {
            const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / kNumDirections;
            const double c = std::cos(angle);
            const double s = std::sin(angle);
            const auto rotation = [&](const std::array<double, 2>& p) {
                return std::array<int, 2>{static_cast<int>(std::lround(c * p[0] - s * p[1])),
                                          static_cast<int>(std::lround(s * p[0] + c * p[1]))};
            };
            directions[k][i] = {{rotation(a)[0], rotation(a)[1], rotation(b)[0], rotation(b)[1]}};
        }
    }
    return directions;
}

// Returns the index of the direction from a corner to the intensity centroid around it.
std::size_t direction(const cv::Mat& image, int column, int row) {
    int moment_x = 0;
    int moment_y = 0;
    for (int dy = -kRadius_px; dy <= kRadius_px; ++dy) {
        const int half =
            static_cast<int>(std::sqrt(static_cast<double>(kRadius_px * kRadius_px - dy * dy)));
        const std::uint8_t* pixels = image.ptr<std::uint8_t>(row + dy) + column;
        for (int dx = -half; dx <= half; ++dx) {
            moment_x += dx * pixels[dx];
            moment_y += dy * pixels[dx];
        }
    }
    const double rotations = std::atan2(moment_y, moment_x) / (2.0 * std::numbers::pi);
    const auto index = static_cast<int>(std::lround(rotations * kNumDirections));
    return static_cast<std::size_t>((index + kNumDirections) % kNumDirections);
}

Descriptor describe(const cv::Mat& smooth, int column, int row, std::size_t turned) {
    static const std::vector<Tests> kDirections = turned_tests();
    const Tests& tests = kDirections[turned];
    Descriptor descriptor{};
    for (std::size_t i = 0; i < tests.size(); ++i) {
        const auto& [ax, ay, bx, by] = tests[i].offset;
        const bool darker = smooth.ptr<std::uint8_t>(row + ay)[column + ax] <
                            smooth.ptr<std::uint8_t>(row + by)[column + bx];
        descriptor[i / 64] |= static_cast<std::uint64_t>(darker) << (i % 64);
    }
    return descriptor;
}

}  // namespace

double description_scale(cv::Size size) {
    const int longer_px = std::max(size.width, size.height);
    return longer_px > types::kLargeWidth_px ? static_cast<double>(longer_px) / kDescribedSize_px
                                             : 1.0;
}

DescribedKeypoints describe_keypoints(const cv::Mat& left) {
    DescribedKeypoints view;
    const auto reduced_by = [&](double scale) {
        return cv::Size(cvRound(left.cols / scale), cvRound(left.rows / scale));
    };
    double scale = description_scale(left.size());
    cv::Mat level = left;
    if (scale > 1.0) cv::resize(left, level, reduced_by(scale), 0.0, 0.0, cv::INTER_AREA);
    CornerScores scores;
    for (int i = 0; i < kNumLevels && std::min(level.cols, level.rows) > 4 * kBorder_px; ++i) {
        cv::Mat smooth;
        cv::GaussianBlur(level, smooth, cv::Size(7, 7), 2.0);
        for (const cv::Point& corner :
             best_of_cells(scores.of(level), CornerScores::kNoise, kBorder_px, kCell_px)) {
            if (view.size() == kMaxKeypoints) break;
            DescribedKeypoint point;
            // Pixel centres of a level lie between those of the full image.
            point.u_px = static_cast<float>((corner.x + 0.5) * scale - 0.5);
            point.v_px = static_cast<float>((corner.y + 0.5) * scale - 0.5);
            point.scale = static_cast<float>(scale);
            const std::size_t turned = direction(smooth, corner.x, corner.y);
            point.direction_rad = static_cast<float>(2.0 * std::numbers::pi / kNumDirections *
                                                     static_cast<double>(turned));
            point.descriptor = describe(smooth, corner.x, corner.y, turned);
            view.push_back(point);
        }
        scale *= kLevelScale;
        const cv::Mat finer = level;
        cv::resize(finer, level, reduced_by(scale), 0.0, 0.0, cv::INTER_LINEAR);
    }
    return view;
}

}  // namespace divemesh::features
