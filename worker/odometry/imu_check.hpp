#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <deque>

#include "worker/odometry/register_points.hpp"
#include "worker/types/known_rotation.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/sensors_left_out.hpp"

namespace divemesh::odometry {

// Returns true if a predicted motion puts the features that vision followed elsewhere in the image
// than they are: the median inlier by more than 3 px. A prediction that is nearer did not mislead
// the search for features.
bool is_elsewhere(const types::RectifiedRig& rig,
                  const Registration& vision,
                  const Eigen::Isometry3d& T_current_previous);

// A check of the IMU against vision from frame to frame. It acts before a wrong sensor bends the
// path or loses the scene; imu::SensorWatch judges over seconds. Vision has a say where most pairs
// agree. Its limits allow for noise, clocks and axes that are not estimated yet.
class ImuCheck {
public:
    ImuCheck(const types::RectifiedRig& rig, const types::ImuNoise& noise)
        : rig_(rig), noise_(noise) {}

    // Takes in a rotation by the gyroscope over `time`, a step after the last one. Returns true if
    // the inliers contradict it, or the sum of it and the steps up to half a second before: a bias
    // that jumps shows in the sum.
    bool contradicts(const Registration& vision,
                     const types::KnownRotation& q_current_previous,
                     const types::TimeInterval& time);
    // Returns true if the inliers contradict the translation that the IMU predicted from a velocity
    // that was known `imu_alone_s` ago.
    bool contradicts(const Registration& vision,
                     const Eigen::Isometry3d& T_current_previous,
                     double imu_alone_s,
                     const types::TimeInterval& time) const;

private:
    struct Step {
        types::TimeInterval time;
        double turned_rad;
        Eigen::Vector3d error_rad;  // of the gyroscope, in the camera's axes
        Eigen::Matrix3d covariance;
    };

    types::RectifiedRig rig_;
    types::ImuNoise noise_;
    std::deque<Step> steps_;
};

}  // namespace divemesh::odometry
