#include "worker/optimisation/expected_path_error.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "worker/optimisation/covariance_between.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::optimisation {
namespace {

// Relative to the largest column; below it the path is straight.
constexpr double kMinRotation = 1e-3;

// Returns, in its columns, the displacements of the positions by the rigid motions about their
// centre.
Eigen::MatrixXd rigid_motions(const std::vector<Eigen::Vector3d>& positions) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : positions) centre += p / static_cast<double>(positions.size());
    Eigen::MatrixXd motions(3 * std::ssize(positions), 6);
    for (Eigen::Index i = 0; i < std::ssize(positions); ++i) {
        const Eigen::Vector3d arm = positions[static_cast<std::size_t>(i)] - centre;
        motions.block<3, 3>(3 * i, 0).setIdentity();
        for (int axis = 0; axis < 3; ++axis)
            motions.block<3, 1>(3 * i, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(arm);
    }
    return motions;
}

Eigen::Matrix3Xd from_centre(const std::vector<Eigen::Vector3d>& positions) {
    Eigen::Matrix3Xd arms(3, std::ssize(positions));
    for (Eigen::Index i = 0; i < arms.cols(); ++i)
        arms.col(i) = positions[static_cast<std::size_t>(i)];
    arms.colwise() -= arms.rowwise().mean().eval();
    return arms;
}

}  // namespace

types::PathUncertainty after_alignment(const std::vector<Eigen::Vector3d>& positions,
                                       const Eigen::MatrixXd& covariance_m2) {
    const Eigen::MatrixXd motions = rigid_motions(positions);
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(motions);
    qr.setThreshold(kMinRotation);
    const Eigen::MatrixXd Q =
        qr.householderQ() * Eigen::MatrixXd::Identity(motions.rows(), qr.rank());
    const Eigen::MatrixXd half = covariance_m2 - Q * (Q.transpose() * covariance_m2);
    const Eigen::MatrixXd projected = half - (half * Q) * Q.transpose();
    const double trace = projected.trace();
    if (trace <= 0.0) return {};
    return {trace / static_cast<double>(positions.size()), trace * trace / projected.squaredNorm()};
}

double vertical_scale_sigma(const std::vector<Eigen::Vector3d>& positions,
                            const Eigen::MatrixXd& covariance_m2) {
    const Eigen::Index num = std::ssize(positions);
    Eigen::MatrixX3d level(num, 3);
    Eigen::VectorXd heights(num);
    for (Eigen::Index i = 0; i < num; ++i) {
        const Eigen::Vector3d& p = positions[static_cast<std::size_t>(i)];
        level.row(i) << p.x(), p.y(), 1.0;
        heights[i] = p.z();
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixX3d> qr(level);
    qr.setThreshold(kMinRotation);
    const Eigen::VectorXd rest = heights - level * qr.solve(heights);
    const double squares = rest.squaredNorm();
    if (squares <= 0.0) return 0.0;
    Eigen::VectorXd along = Eigen::VectorXd::Zero(3 * num);
    for (Eigen::Index i = 0; i < num; ++i) along[3 * i + 2] = rest[i];
    return std::sqrt(std::max(0.0, along.dot(covariance_m2 * along))) / squares;
}

double spread_m2(const std::vector<Eigen::Vector3d>& positions) {
    return from_centre(positions).squaredNorm() / static_cast<double>(positions.size());
}

double scale_sigma(const std::vector<Eigen::Vector3d>& positions,
                   const Eigen::MatrixXd& covariance_m2) {
    const Eigen::Matrix3Xd arms = from_centre(positions);
    const double squares = arms.squaredNorm();
    if (squares <= 0.0) return 0.0;
    const Eigen::Map<const Eigen::VectorXd> along(arms.data(), arms.size());
    return std::sqrt(std::max(0.0, along.dot(covariance_m2 * along))) / squares;
}

types::PathUncertainty with_frames_between(types::PathUncertainty keyframes,
                                           const types::CovarianceTrack& of_keyframes,
                                           const types::CovarianceTrack& of_frames) {
    if (!keyframes.is_known()) return keyframes;
    for (const types::PoseCovariance& frame : of_frames)
        keyframes.mean_square_m2 +=
            (frame.position_m2 - covariance_between(of_keyframes, frame.timestamp_ns).position_m2)
                .trace() /
            static_cast<double>(of_frames.size());
    return keyframes;
}

double shared_sigma_m(const types::PathUncertainty& path) {
    return std::sqrt(path.mean_square_m2 / 3.0);
}

double quantile_95(double mean_square, double degrees_of_freedom) {
    return mean_square * stats::chi_square_quantile(0.95, degrees_of_freedom) / degrees_of_freedom;
}

double squared_length_95(const Eigen::Matrix3d& covariance) {
    const double trace = covariance.trace();
    if (trace <= 0.0) return 0.0;
    return quantile_95(trace, trace * trace / covariance.squaredNorm());
}

}  // namespace divemesh::optimisation
