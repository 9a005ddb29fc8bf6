#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/loops/motions_in_sight.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/landmark.hpp"
#include "worker/types/motion_sigma.hpp"

namespace divemesh::loops {

// A model of the track's drift between two keyframes: a fraction of the distance travelled plus,
// where no landmarks connect neighbours, the error of the frames between them, or, while the scene
// was out of sight, the error of the inertial sensors, or without them the possible motion of a
// diver. It also determines which keyframes the track itself connects; a loop between them gives no
// new information.
class DriftModel {
public:
    // `inertial` is nullptr without inertial sensors. `in_sight` is of every keyframe; empty: the
    // frames between keyframes measured no motion.
    DriftModel(const std::vector<types::Keyframe>& keyframes,
               const std::vector<types::Landmark>& landmarks,
               const imu::InertialPrior* inertial,
               const MotionsInSight& in_sight = {});

    // Return the standard deviation of the pose of one keyframe relative to the other.
    double position_sigma_m(std::size_t a, std::size_t b) const;
    double orientation_sigma_rad(std::size_t a, std::size_t b) const;

    // Returns true if the measured `T_a_b` is within 3.5 sigma of `expected`, including the
    // measurement's own sigma.
    bool allows(std::size_t a,
                std::size_t b,
                const Eigen::Isometry3d& T_a_b,
                const Eigen::Isometry3d& expected,
                double measured_sigma_m) const;

    // Returns the first keyframe that the track connects to this one, directly or over one between.
    std::size_t first_covisible(std::size_t keyframe) const { return first_covisible_[keyframe]; }
    // Returns the segment of a keyframe: keyframes between which the scene was never lost share
    // one.
    std::int32_t segment(std::size_t keyframe) const { return segment_[keyframe]; }
    // Returns true if a keyframe's pose relative to the previous one is known: the scene stayed in
    // sight, was lost for less than a second, or the inertial sensors bridged the gap.
    bool follows(std::size_t keyframe) const { return follows_[keyframe]; }
    // Returns how well the frames from the previous keyframe to this one know the motion, where too
    // few landmarks connect the two though the scene stayed in sight; nullopt elsewhere.
    const std::optional<types::MotionSigma>& by_frames_alone(std::size_t keyframe) const {
        return by_frames_alone_[keyframe];
    }

private:
    // Standard deviations accumulated while the scene was out of sight.
    struct TrackingGap {
        double position_m = 0.0;
        double rotation_rad = 0.0;
    };
    static TrackingGap tracking_gap(const imu::InertialPrior* inertial,
                                    std::int64_t from_ns,
                                    std::int64_t to_ns);

    std::vector<double> path_m_;              // up to each keyframe
    std::vector<TrackingGap> tracking_gaps_;  // up to each keyframe
    std::vector<std::int32_t> segment_;
    std::vector<bool> follows_;
    MotionsInSight by_frames_alone_;
    std::vector<std::size_t> first_covisible_;
};

}  // namespace divemesh::loops
