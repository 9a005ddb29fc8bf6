#include "tests/bench/sift_baseline.hpp"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/features2d.hpp>
#include <optional>

namespace divemesh::bench {
namespace {

constexpr int kNumFeatures = 1000;
constexpr int kOctaveLayers = 3;
constexpr double kContrast = 0.02;       // as COLMAP's; OpenCV's own is too high for hazy water
constexpr float kRatio = 0.8F;           // Lowe 2004
constexpr double kMaxEpipolar_px = 1.5;  // from the epipolar line
constexpr double kMaxReprojection_px = 2.0;
constexpr int kMinInliers = 15;
constexpr int kIterations = 300;
constexpr double kConfidence = 0.999;

// Keypoints without distortion, on the plane at depth 1.
struct Keypoints {
    std::vector<cv::Point2d> points;
    cv::Mat descriptors;
};

struct Points {
    std::vector<cv::Point3d> p_cam0;
    cv::Mat descriptors;
};

cv::Mat camera_matrix(const types::Camera& camera) {
    return (cv::Mat_<double>(3, 3) << camera.fx_px,
            0.0,
            camera.cx_px,
            0.0,
            camera.fy_px,
            camera.cy_px,
            0.0,
            0.0,
            1.0);
}

Keypoints detect(cv::SIFT& sift, const cv::Mat& image, const types::Camera& camera) {
    std::vector<cv::KeyPoint> found;
    Keypoints keypoints;
    sift.detectAndCompute(image, {}, found, keypoints.descriptors);
    std::vector<cv::Point2f> pixels;
    cv::KeyPoint::convert(found, pixels);
    if (!pixels.empty())
        cv::undistortPoints(
            std::vector<cv::Point2d>(pixels.begin(), pixels.end()),
            keypoints.points,
            camera_matrix(camera),
            cv::Mat(1, 4, CV_64F, const_cast<double*>(camera.distortion_coefficients.data())));
    return keypoints;
}

std::vector<cv::DMatch> match(const cv::Mat& query, const cv::Mat& train) {
    std::vector<cv::DMatch> good;
    if (query.rows < 2 || train.rows < 2) return good;
    std::vector<std::vector<cv::DMatch>> nearest;
    cv::BFMatcher(cv::NORM_L2).knnMatch(query, train, nearest, 2);
    for (const auto& pair : nearest)
        if (pair.size() == 2 && pair[0].distance < kRatio * pair[1].distance)
            good.push_back(pair[0]);
    return good;
}

// Distance of a point of cam1 from the epipolar line of one of cam0, on the plane at depth 1.
double epipolar_distance(const Eigen::Isometry3d& T_cam1_cam0,
                         const cv::Point2d& left,
                         const cv::Point2d& right) {
    const Eigen::Vector3d line = T_cam1_cam0.translation().cross(
        T_cam1_cam0.linear() * Eigen::Vector3d(left.x, left.y, 1.0));
    return std::abs(line.dot(Eigen::Vector3d(right.x, right.y, 1.0))) / line.head<2>().norm();
}

// The point in cam0 nearest to both rays, by linear least squares; nullopt behind the camera.
std::optional<cv::Point3d> triangulate(const Eigen::Isometry3d& T_cam1_cam0,
                                       const cv::Point2d& left,
                                       const cv::Point2d& right) {
    const Eigen::Isometry3d T_cam0_cam1 = T_cam1_cam0.inverse();
    const Eigen::Vector3d a(left.x, left.y, 1.0);
    const Eigen::Vector3d b = T_cam0_cam1.linear() * Eigen::Vector3d(right.x, right.y, 1.0);
    Eigen::Matrix<double, 3, 2> rays;
    rays << a, -b;
    const Eigen::Vector2d depths = rays.colPivHouseholderQr().solve(T_cam0_cam1.translation());
    if (depths.minCoeff() <= 0.0) return std::nullopt;
    const Eigen::Vector3d p = depths[0] * a;
    return cv::Point3d(p.x(), p.y(), p.z());
}

Points stereo_points(const Keypoints& left, const Keypoints& right, const types::Rig& rig) {
    const Eigen::Isometry3d T_cam1_cam0 = rig.T_cam1_cam0();
    Points points;
    for (const cv::DMatch& pair : match(left.descriptors, right.descriptors)) {
        const cv::Point2d& l = left.points[static_cast<std::size_t>(pair.queryIdx)];
        const cv::Point2d& r = right.points[static_cast<std::size_t>(pair.trainIdx)];
        if (epipolar_distance(T_cam1_cam0, l, r) * rig.cam1.fx_px > kMaxEpipolar_px) continue;
        const auto p_cam0 = triangulate(T_cam1_cam0, l, r);
        if (!p_cam0) continue;
        points.p_cam0.push_back(*p_cam0);
        points.descriptors.push_back(left.descriptors.row(pair.queryIdx));
    }
    return points;
}

// The camera now in the camera before; nullopt if too few points agree.
std::optional<Eigen::Isometry3d> link(const Points& before,
                                      const Keypoints& now,
                                      const types::Camera& camera) {
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> seen;
    for (const cv::DMatch& pair : match(before.descriptors, now.descriptors)) {
        points.push_back(before.p_cam0[static_cast<std::size_t>(pair.queryIdx)]);
        seen.push_back(now.points[static_cast<std::size_t>(pair.trainIdx)]);
    }
    if (static_cast<int>(points.size()) < kMinInliers) return std::nullopt;
    cv::Mat rotation;
    cv::Mat translation;
    std::vector<int> inliers;
    const auto max_error = static_cast<float>(kMaxReprojection_px / camera.fx_px);
    cv::setRNGSeed(0);
    if (!cv::solvePnPRansac(points,
                            seen,
                            cv::Mat::eye(3, 3, CV_64F),
                            {},
                            rotation,
                            translation,
                            false,
                            kIterations,
                            max_error,
                            kConfidence,
                            inliers) ||
        static_cast<int>(inliers.size()) < kMinInliers)
        return std::nullopt;
    Eigen::Vector3d w;
    Eigen::Isometry3d T_now_before = Eigen::Isometry3d::Identity();
    cv::cv2eigen(rotation, w);
    Eigen::Vector3d t;
    cv::cv2eigen(translation, t);
    if (w.norm() > 0.0)
        T_now_before.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
    T_now_before.translation() = t;
    return T_now_before.inverse();
}

}  // namespace

double SiftPath::linked_share() const {
    return num_frames > 1 ? static_cast<double>(num_links) / (num_frames - 1) : 0.0;
}

const SiftChain* SiftPath::longest() const {
    const auto found =
        std::max_element(chains.begin(), chains.end(), [](const auto& a, const auto& b) {
            return a.T_first_cam0.size() < b.T_first_cam0.size();
        });
    return found == chains.end() ? nullptr : &*found;
}

SiftPath sift_path(types::Recording& dive) {
    const auto sift = cv::SIFT::create(kNumFeatures, kOctaveLayers, kContrast);
    const types::Rig& rig = dive.rig();
    SiftPath path;
    Points before;
    while (const auto frame = dive.next_frame()) {
        const Keypoints left = detect(*sift, frame->left, rig.cam0);
        const auto T_before_now = link(before, left, rig.cam0);
        if (!T_before_now) path.chains.emplace_back();
        auto& chain = path.chains.back().T_first_cam0;
        chain.push_back({frame->timestamp_ns,
                         T_before_now ? chain.back().T_world_imu * *T_before_now
                                      : Eigen::Isometry3d::Identity()});
        path.num_links += T_before_now ? 1 : 0;
        ++path.num_frames;
        before = stereo_points(left, detect(*sift, frame->right, rig.cam1), rig);
    }
    return path;
}

}  // namespace divemesh::bench
