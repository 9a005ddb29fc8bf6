#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "worker/reconstruct.hpp"

namespace divemesh::worker {

// How far the track may have run off between two keyframes: a share of the way swum, and what a
// diver may have done while the scene was out of sight. Also which keyframes the track itself ties
// together, so that nothing is to be learnt from seeing them again.
class DriftBound {
public:
    DriftBound(const std::vector<Keyframe>& keyframes, const std::vector<Landmark>& landmarks);

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
    std::size_t first_tied(std::size_t keyframe) const { return first_tied_[keyframe]; }
    // Keyframes between which the scene was never out of sight have the same piece.
    std::int32_t piece(std::size_t keyframe) const { return piece_[keyframe]; }

    // Time between the two without the scene.
    double blind_s(std::size_t a, std::size_t b) const;

private:
    double path_m(std::size_t a, std::size_t b) const;

    std::vector<double> path_m_;   // up to each keyframe
    std::vector<double> blind_s_;  // time without the scene, up to each keyframe
    std::vector<std::int32_t> piece_;
    std::vector<std::size_t> first_tied_;
};

}  // namespace divemesh::worker
