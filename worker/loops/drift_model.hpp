#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/landmark.hpp"

namespace divemesh::loops {

// How far the track may have run off between two keyframes: a share of the way swum, and while the
// scene was out of sight what the inertial sensors may have erred by, or without them what a diver
// may have done. Also which keyframes the track itself ties together, so that nothing is to be
// learnt from seeing them again.
class DriftModel {
public:
    // `inertial`: nullptr without sensors.
    DriftModel(const std::vector<types::Keyframe>& keyframes,
               const std::vector<types::Landmark>& landmarks,
               const imu::InertialPrior* inertial);

    // One standard deviation of the pose of one keyframe seen from the other.
    double position_sigma_m(std::size_t a, std::size_t b) const;
    double orientation_sigma_rad(std::size_t a, std::size_t b) const;

    // `T_a_b` as measured against `expected`: within 3.5 sigma, the measurement's own included.
    bool allows(std::size_t a,
                std::size_t b,
                const Eigen::Isometry3d& T_a_b,
                const Eigen::Isometry3d& expected,
                double measured_sigma_m) const;

    // The first keyframe that the track ties to this one, directly or by one between.
    std::size_t first_covisible(std::size_t keyframe) const { return first_covisible_[keyframe]; }
    // Keyframes between which the scene was never out of sight have the same piece.
    std::int32_t segment(std::size_t keyframe) const { return segment_[keyframe]; }
    // Whether a keyframe's place against the one before it is known: the scene stayed in sight, or
    // was away for less than a second, or inertia carried the track over.
    bool follows(std::size_t keyframe) const { return follows_[keyframe]; }

private:
    // Standard deviations that added up while the scene was out of sight.
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
    std::vector<std::size_t> first_covisible_;
};

}  // namespace divemesh::loops
