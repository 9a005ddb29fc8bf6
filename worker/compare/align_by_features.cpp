#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "worker/base/hashed_random.hpp"
#include "worker/base/horn.hpp"
#include "worker/compare/coarse_alignment.hpp"
#include "worker/compare/surface_raster.hpp"
#include "worker/mesh/mean_edge.hpp"

namespace divemesh::compare {
namespace {

constexpr std::int64_t kMaxCells = 3'000'000;
constexpr double kMinCell_m = 0.008;
constexpr int kMaxFeatures = 6000;
constexpr float kRatio = 0.85F;      // distance of the best match to that of the second (Lowe 2004)
constexpr double kOnPlace_m = 0.06;  // of inlier pairs
constexpr double kApart_m = 0.3;     // of pairs that determine a heading
constexpr std::size_t kMinNumPairs = 12;
constexpr int kRounds = 20000;

struct Described {
    std::vector<Eigen::Vector3d> points;
    cv::Mat descriptors;
};

cv::Mat grey_of(const types::Mesh& mesh, const SurfaceRaster& raster) {
    std::vector<float> brightness(mesh.vertices.size());
    for (std::size_t i = 0; i < brightness.size(); ++i) {
        const types::Color& c = mesh.colors[i];
        brightness[i] = 0.299F * static_cast<float>(c[0]) + 0.587F * static_cast<float>(c[1]) +
                        0.114F * static_cast<float>(c[2]);
    }
    cv::Mat grey(raster.triangle.size(), CV_8U, cv::Scalar::all(0));
    for (int row = 0; row < grey.rows; ++row)
        for (int column = 0; column < grey.cols; ++column)
            if (raster.seen(row, column))
                grey.at<std::uint8_t>(row, column) = cv::saturate_cast<std::uint8_t>(
                    raster.interpolate(mesh, brightness, row, column));
    // Equalises brightness, because water and lamps differ between dives.
    cv::createCLAHE(4.0, cv::Size(12, 12))->apply(grey, grey);
    return grey;
}

Described describe(const types::Mesh& mesh) {
    const RasterGrid grid =
        grid_over(mesh, mesh, std::max(kMinCell_m, mesh::mean_edge_m(mesh)), kMaxCells);
    const SurfaceRaster raster = rasterise(mesh, grid);
    cv::Mat mask(raster.triangle.size(), CV_8U, cv::Scalar::all(0));
    for (int row = 0; row < mask.rows; ++row)
        for (int column = 0; column < mask.cols; ++column)
            if (raster.seen(row, column)) mask.at<std::uint8_t>(row, column) = 255;
    // The border of the seen ground must not give features.
    cv::erode(mask, mask, cv::Mat::ones(11, 11, CV_8U));
    std::vector<cv::KeyPoint> keypoints;
    Described result;
    cv::SIFT::create(kMaxFeatures, 3, 0.02)
        ->detectAndCompute(grey_of(mesh, raster), mask, keypoints, result.descriptors);
    for (const cv::KeyPoint& keypoint : keypoints) {
        const int row = std::clamp(static_cast<int>(std::lround(keypoint.pt.y)), 0, mask.rows - 1);
        const int column =
            std::clamp(static_cast<int>(std::lround(keypoint.pt.x)), 0, mask.cols - 1);
        const Eigen::Vector2d at = grid.center(row, column);
        result.points.emplace_back(
            at.x(), at.y(), static_cast<double>(raster.height_m.at<float>(row, column)));
    }
    return result;
}

struct Pairs {
    std::vector<Eigen::Vector3d> a;
    std::vector<Eigen::Vector3d> b;
};

Pairs match(const Described& a, const Described& b) {
    Pairs pairs;
    if (a.points.size() < 2 || b.points.size() < 2) return pairs;
    std::vector<std::vector<cv::DMatch>> matches;
    cv::BFMatcher(cv::NORM_L2).knnMatch(b.descriptors, a.descriptors, matches, 2);
    for (const auto& best : matches) {
        if (best.size() < 2 || best[0].distance > kRatio * best[1].distance) continue;
        const Eigen::Vector3d& of_a = a.points[static_cast<std::size_t>(best[0].trainIdx)];
        const Eigen::Vector3d& of_b = b.points[static_cast<std::size_t>(best[0].queryIdx)];
        if (!std::isfinite(of_a.z()) || !std::isfinite(of_b.z())) continue;
        pairs.a.push_back(of_a);
        pairs.b.push_back(of_b);
    }
    return pairs;
}

// Returns the rotation about the vertical and the shift that map two points of b to their partners.
std::optional<Eigen::Isometry3d> pose_of(const Pairs& pairs, std::size_t i, std::size_t j) {
    const Eigen::Vector3d of_a = pairs.a[j] - pairs.a[i];
    const Eigen::Vector3d of_b = pairs.b[j] - pairs.b[i];
    if (of_b.head<2>().norm() < kApart_m || (of_a.norm() - of_b.norm()) > kOnPlace_m ||
        (of_a.norm() - of_b.norm()) < -kOnPlace_m || std::abs(of_a.z() - of_b.z()) > kOnPlace_m)
        return std::nullopt;
    const double heading = std::atan2(of_a.y(), of_a.x()) - std::atan2(of_b.y(), of_b.x());
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T.translation() =
        0.5 * (pairs.a[i] + pairs.a[j]) - T.linear() * (0.5 * (pairs.b[i] + pairs.b[j]));
    return T;
}

Pairs find_inliers(const Pairs& pairs, const Eigen::Isometry3d& T_a_b) {
    Pairs some;
    for (std::size_t i = 0; i < pairs.a.size(); ++i)
        if ((T_a_b * pairs.b[i] - pairs.a[i]).norm() < kOnPlace_m) {
            some.a.push_back(pairs.a[i]);
            some.b.push_back(pairs.b[i]);
        }
    return some;
}

}  // namespace

std::vector<CoarseAlignment> align_by_features(const types::Mesh& a,
                                               const types::Mesh& b,
                                               std::uint64_t seed) {
    if (a.colors.empty() || b.colors.empty() || a.triangles.empty() || b.triangles.empty())
        return {};
    const Pairs pairs = match(describe(a), describe(b));
    if (pairs.a.size() < kMinNumPairs) return {};
    base::RandomRow random(base::hash64(seed, 0x6665617475726573ULL));
    Pairs best;
    const auto draw = [&] { return static_cast<std::size_t>(random.next() % pairs.a.size()); };
    for (int round = 0; round < kRounds; ++round) {
        const std::size_t i = draw();
        const std::size_t j = draw();
        const auto T_a_b = i == j ? std::nullopt : pose_of(pairs, i, j);
        if (!T_a_b) continue;
        Pairs some = find_inliers(pairs, *T_a_b);
        if (some.a.size() > best.a.size()) best = std::move(some);
    }
    if (best.a.size() < kMinNumPairs) return {};
    const auto horn = base::absolute_orientation(best.b, best.a);
    if (!horn) return {};
    best = find_inliers(pairs, horn->T_b_a);
    if (best.a.size() < kMinNumPairs) return {};
    return {{horn->T_b_a, "features", static_cast<double>(best.a.size())}};
}

}  // namespace divemesh::compare
