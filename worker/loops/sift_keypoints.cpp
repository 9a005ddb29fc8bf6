#include "worker/loops/sift_keypoints.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/features/match_sparse_stereo.hpp"
#include "worker/loops/nearest_two.hpp"

namespace divemesh::loops {
namespace {

constexpr int kMaxKeypoints = 2000;
constexpr int kOctaveLayers = 3;
constexpr double kMinContrast = 0.015;  // a third of Lowe's: haze leaves little
constexpr double kMaxEdgeRatio = 10.0;
constexpr double kFirstSigma = 1.6;
// A larger image is halved first: its finest structures are noise and cost four times as much.
constexpr double kMaxPixels = 800'000.0;
constexpr double kRatio = 0.8;
constexpr double kGuidedShare = 0.125;  // of the image width
// Standard deviation of a position by the keypoint's diameter, and its min, px.
constexpr double kSigmaShare = 0.1;
constexpr double kMinSigma_px = 0.5;

struct Described {
    std::vector<cv::KeyPoint> keypoints;  // in the full image
    cv::Mat descriptors;                  // CV_32F, a row per keypoint
};

Described describe(const cv::Mat& left) {
    cv::Mat image = left;
    float scale = 1.0F;
    while (static_cast<double>(image.total()) > kMaxPixels) {
        cv::Mat half;
        cv::pyrDown(image, half);
        image = half;
        scale *= 2.0F;
    }
    Described found;
    cv::SIFT::create(kMaxKeypoints, kOctaveLayers, kMinContrast, kMaxEdgeRatio, kFirstSigma)
        ->detectAndCompute(image, cv::noArray(), found.keypoints, found.descriptors);
    for (cv::KeyPoint& keypoint : found.keypoints) {
        keypoint.pt *= scale;
        keypoint.size *= scale;
    }
    return found;
}

Eigen::VectorXf root_of(const cv::Mat& row) {
    const Eigen::Map<const Eigen::VectorXf> sift(row.ptr<float>(), row.cols);
    return (sift / std::max(1.0F, sift.sum())).cwiseSqrt();
}

using Nearest = NearestTwo<float, std::greater<float>>;  // by the cosine of the angle between
constexpr float kFarthest = -1.0F;

// Squared distances of unit vectors are 2 - 2 cos.
bool distinct(const Nearest& nearest) {
    return 1.0F - nearest.first < static_cast<float>(kRatio * kRatio) * (1.0F - nearest.second);
}

// Returns where a motion leads the points; empty without one.
std::vector<Eigen::Vector2d> expected_pixels(const types::RectifiedRig& rig,
                                             const SiftKeypoints& a,
                                             const std::optional<Eigen::Isometry3d>& T_b_a) {
    std::vector<Eigen::Vector2d> pixels;
    if (!T_b_a) return pixels;
    for (const types::Feature& point : a.points)
        pixels.push_back(rig.pixel(*T_b_a * types::point_cam(rig, point)));
    return pixels;
}

}  // namespace

SiftKeypoints sift_keypoints(const types::RectifiedFrame& frame, int num_disparities_px) {
    const Described found = describe(frame.left);
    types::Features points;
    for (std::size_t i = 0; i < found.keypoints.size(); ++i)
        points.push_back({static_cast<std::int64_t>(i),
                          {found.keypoints[i].pt.x, found.keypoints[i].pt.y},
                          0.0});
    features::match_sparse_stereo(frame, {}, num_disparities_px, points);
    std::erase_if(points, [](const types::Feature& point) { return !types::has_depth(point); });

    SiftKeypoints result;
    result.descriptors.resize(found.descriptors.cols, static_cast<Eigen::Index>(points.size()));
    for (types::Feature& point : points) {
        const auto i = static_cast<std::size_t>(point.id);
        point.id = static_cast<std::int64_t>(result.points.size());
        result.descriptors.col(point.id) = root_of(found.descriptors.row(static_cast<int>(i)));
        result.sigma_px.push_back(
            std::max(kMinSigma_px, kSigmaShare * static_cast<double>(found.keypoints[i].size)));
        result.points.push_back(point);
    }
    return result;
}

odometry::PointPairs match_sift(const types::RectifiedRig& rig,
                                const SiftKeypoints& a,
                                const SiftKeypoints& b,
                                const std::optional<Eigen::Isometry3d>& T_b_a) {
    const std::vector<Eigen::Vector2d> expected_px = expected_pixels(rig, a, T_b_a);
    const double radius_px = kGuidedShare * rig.width_px;
    const Eigen::MatrixXf cosines = a.descriptors.transpose() * b.descriptors;
    std::vector<Nearest> of_a(a.points.size(), Nearest(kFarthest));
    std::vector<Nearest> of_b(b.points.size(), Nearest(kFarthest));
    for (Eigen::Index j = 0; j < cosines.cols(); ++j) {
        for (Eigen::Index i = 0; i < cosines.rows(); ++i) {
            const auto from = static_cast<std::size_t>(i);
            const auto to = static_cast<std::size_t>(j);
            if (T_b_a && (b.points[to].pixel - expected_px[from]).norm() > radius_px) continue;
            of_a[from].offer(static_cast<int>(j), cosines(i, j));
            of_b[to].offer(static_cast<int>(i), cosines(i, j));
        }
    }
    odometry::PointPairs pairs;
    for (std::size_t i = 0; i < of_a.size(); ++i) {
        if (of_a[i].index < 0 || !distinct(of_a[i])) continue;
        const auto j = static_cast<std::size_t>(of_a[i].index);
        if (of_b[j].index != static_cast<int>(i)) continue;
        odometry::PointPair pair;
        pair.id = a.points[i].id;
        pair.previous_px = types::measurement_px(a.points[i]);
        pair.current_px = types::measurement_px(b.points[j]);
        pair.previous_sigma_px.head<2>().setConstant(a.sigma_px[i]);
        pair.current_sigma_px.head<2>().setConstant(b.sigma_px[j]);
        pair.p_previous = types::point_cam(rig, a.points[i]);
        pair.p_current = types::point_cam(rig, b.points[j]);
        pairs.push_back(pair);
    }
    return pairs;
}

}  // namespace divemesh::loops
