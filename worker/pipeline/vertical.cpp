#include "worker/pipeline/vertical.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace divemesh::pipeline {
namespace {

constexpr double kMaxTilt_rad = 0.05;  // standard deviation of a vertical that counts as known

bool is_one_segment(const std::vector<types::Keyframe>& keyframes) {
    return std::ranges::all_of(keyframes, [&](const types::Keyframe& keyframe) {
        return keyframe.segment == keyframes.front().segment;
    });
}

// Returns true if the depths at the keyframes determine the tilt of the path: least squares of
// depth = offset + tilt . (x, y). Their standard deviations are for independent errors.
bool pressure_tells_tilt(const imu::InertialPrior& inertial,
                         const std::vector<types::Keyframe>& keyframes) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        const imu::SensorReadings readings =
            inertial.readings(keyframes[k - 1].timestamp_ns, keyframes[k].timestamp_ns);
        if (!readings.depth_m) continue;
        const Eigen::Vector2d p_m = keyframes[k].T_world_cam.translation().head<2>();
        const Eigen::Vector3d row(p_m.x(), p_m.y(), 1.0);
        information += row * row.transpose() / (readings.depth_sigma_m * readings.depth_sigma_m);
    }
    if (information(2, 2) <= 0.0) return false;
    const Eigen::Matrix2d of_tilt = information.topLeftCorner<2, 2>() -
                                    information.topRightCorner<2, 1>() *
                                        information.bottomLeftCorner<1, 2>() / information(2, 2);
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(of_tilt).eigenvalues()[0];
    return least * kMaxTilt_rad * kMaxTilt_rad >= 1.0;
}

}  // namespace

bool vertical_is_known(const imu::InertialPrior& inertial, const types::OptimisedTrack& optimised) {
    if (optimised.trajectory.empty()) return false;
    if (inertial.knows_vertical(optimised.trajectory.front().timestamp_ns)) return true;
    // All else turns the world upright only in the adjustment of the whole dive.
    if (optimised.covariances.empty()) return false;
    const std::vector<types::Keyframe>& keyframes = optimised.keyframes;
    return std::ranges::any_of(keyframes,
                               [&](const types::Keyframe& keyframe) {
                                   return inertial.knows_vertical(keyframe.timestamp_ns);
                               }) ||
           (is_one_segment(keyframes) && pressure_tells_tilt(inertial, keyframes));
}

}  // namespace divemesh::pipeline
