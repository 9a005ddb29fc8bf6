#include "worker/board_calibration/board_pose.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "worker/base/rotation_vector.hpp"
#include "worker/camera/projection.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr double kMaxTangent = 20.0;  // of a ray to the axis: 87 degrees

std::optional<double> rms_px(const types::Camera& camera,
                             const boards::Board& board,
                             const boards::BoardCorners& corners,
                             const Eigen::Isometry3d& T_cam_board) {
    double squares = 0.0;
    for (const boards::BoardCorner& corner : corners) {
        const auto pixel = camera::project(camera, T_cam_board * board.corner_m(corner.corner));
        if (!pixel) return std::nullopt;
        squares += (*pixel - corner.pixel).squaredNorm();
    }
    return std::sqrt(squares / (2.0 * static_cast<double>(corners.size())));
}

// Returns true if the corners spread over both axes of the board.
bool spread_over_plane(const boards::Board& board, const boards::BoardCorners& corners) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    for (const auto& corner : corners) mean += board.corner_m(corner.corner).head<2>();
    mean /= static_cast<double>(corners.size());
    for (const auto& corner : corners) {
        const Eigen::Vector2d d = board.corner_m(corner.corner).head<2>() - mean;
        squares += d * d.transpose();
    }
    return squares.determinant() > 1e-4 * squares.trace() * squares.trace();
}

Eigen::Isometry3d isometry(const cv::Mat& rotation_vector, const cv::Mat& translation) {
    const auto vector = [](const cv::Mat& m) {
        return Eigen::Vector3d(m.at<double>(0), m.at<double>(1), m.at<double>(2));
    };
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = base::rotation_from_vector(vector(rotation_vector)).toRotationMatrix();
    T.translation() = vector(translation);
    return T;
}

}  // namespace

std::optional<BoardPose> find_board_pose(const types::Camera& camera,
                                         const boards::Board& board,
                                         const boards::BoardCorners& corners) {
    if (corners.size() < kMinCorners || !spread_over_plane(board, corners)) return std::nullopt;
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> rays;
    for (const boards::BoardCorner& corner : corners) {
        const Eigen::Vector3d p = board.corner_m(corner.corner) - board.center_m();
        const Eigen::Vector3d ray = camera::unproject(camera, corner.pixel);
        if (!ray.allFinite() || ray.head<2>().norm() > kMaxTangent) return std::nullopt;
        points.emplace_back(p.x(), p.y(), p.z());
        rays.emplace_back(ray.x(), ray.y());
    }
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    try {
        cv::solvePnPGeneric(points,
                            rays,
                            cv::Mat::eye(3, 3, CV_64F),
                            cv::Mat(),
                            rotations,
                            translations,
                            false,
                            cv::SOLVEPNP_IPPE);
    } catch (const cv::Exception&) {  // degenerate corners
        return std::nullopt;
    }
    std::optional<BoardPose> best;
    for (std::size_t i = 0; i < rotations.size(); ++i) {
        Eigen::Isometry3d T = isometry(rotations[i], translations[i]);
        T.translation() -= T.linear() * board.center_m();
        if (!T.matrix().allFinite()) continue;
        const auto rms = rms_px(camera, board, corners, T);
        if (rms && (!best || *rms < best->rms_px)) best = BoardPose{T, *rms};
    }
    return best;
}

}  // namespace divemesh::board_calibration
