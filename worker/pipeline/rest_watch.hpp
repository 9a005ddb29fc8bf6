#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/odometry/rest_detector.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rest.hpp"

namespace divemesh::pipeline {

// Recognises a rig at rest by images and IMU together.
class RestWatch {
public:
    RestWatch(const types::RectifiedRig& rig,
              imu::InertialPrior& inertial,
              odometry::MotionModel& motion)
        : rig_(rig), inertial_(inertial), motion_(motion), detector_(rig) {}

    // Returns T_current_previous of a rig that hardly moves, given all features of the frame and
    // the motion as estimated; nullopt if it moves. `motion` is still at the previous frame.
    std::optional<Eigen::Isometry3d> watch(const odometry::Registration& vision,
                                           const types::Features& features,
                                           const Eigen::Isometry3d& estimated,
                                           std::int64_t now_ns);
    // Uses that the rig rests, once `motion` has advanced to the frame.
    void settle(std::int64_t now_ns);
    // Takes in that the pose in `motion` was corrected.
    void correct() { detector_.correct(motion_.T_world_cam()); }
    // Returns when the rest began, if the rig rested in the last frame.
    std::optional<std::int64_t> resting_since() const {
        return detector_.at_rest() ? std::optional(detector_.began_ns()) : std::nullopt;
    }
    // Returns true if the image has hardly moved since an earlier frame, however recent.
    bool hardly_moves() const { return detector_.hardly_moves(); }
    // Returns true if the rig rested in the last frame, if the IMU measured no motion since, and if
    // most of what vision followed into this frame stayed in place. The motion by vision may be
    // that of fish or light then.
    bool confirmed_by_imu(const odometry::Registration& vision, std::int64_t now_ns) const;
    // Returns true if images and IMU showed a rest up to two seconds ago. The velocity that the
    // sliding window gives to the first keyframes after a rest has the error of the forces of the
    // whole rest.
    bool rested_lately(std::int64_t now_ns) const;
    // Returns the rests so far.
    const std::vector<types::Rest>& rests() const { return rests_; }

private:
    bool rotates_by_gyroscope(std::int64_t now_ns) const;
    bool rests_by_imu(std::int64_t now_ns) const;

    types::RectifiedRig rig_;
    imu::InertialPrior& inertial_;
    odometry::MotionModel& motion_;
    odometry::RestDetector detector_;
    std::vector<types::Rest> rests_;
    std::optional<std::int64_t> confirmed_ns_;  // when images and IMU last showed a rest
};

}  // namespace divemesh::pipeline
