#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/types/rectified_rig.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::calibration {

// A point as two pairs measured it: u, v, disparity in the rectified left image.
struct RangeMatch {
    Eigen::Vector3d before_px = Eigen::Vector3d::Zero();
    Eigen::Vector3d after_px = Eigen::Vector3d::Zero();
};

// Two pairs of one recording and the points that both measured.
struct RangeWindow {
    Eigen::Isometry3d T_after_before =
        Eigen::Isometry3d::Identity();  // of the left camera, a guess
    std::vector<RangeMatch> matches;
};

// The unknowns that bend ranges: yaw of the right camera (rad), its principal point (px to the
// right), k1 of the left and of the right lens.
constexpr int kNumRangeUnknowns = 4;
using RangeUnknowns = Eigen::Matrix<double, kNumRangeUnknowns, 1>;
using RangeCovariance = Eigen::Matrix<double, kNumRangeUnknowns, kNumRangeUnknowns>;

struct RangeSolution {
    RangeUnknowns values = RangeUnknowns::Zero();
    RangeCovariance covariance = RangeCovariance::Zero();
    double error_px = 0.0;  // robust standard deviation of a measured coordinate
    int num_windows = 0;    // that constrain the unknowns
    int num_matches = 0;    // inliers
    double bias_px = 0.0;   // by which disparities in the middle of the image are too large
    double bias_sigma_px = 0.0;
    types::SolverOutcome outcome;  // failed without windows
};

// Returns the unknowns that make the ranges of a scene agree from frame to frame. A wrong yaw or
// principal point shifts all disparities, so points seem to move as in no rigid scene. Solves by
// least squares over the motion of each window and the shared unknowns, with the residual
//
//     r = (u, v, d)_after - project(T_after_before triangulate(u, v, d)_before)
//
// weighted by the covariance that the noise of all four pixels gives it; outliers lose their weight
// (Tukey's biweight). `prior` is the expected value of the unknowns with its standard deviations.
RangeSolution solve_ranges(const types::RectifiedRig& rig,
                           const std::vector<RangeWindow>& windows,
                           const RangeUnknowns& prior,
                           const RangeUnknowns& prior_sigmas);

}  // namespace divemesh::calibration
