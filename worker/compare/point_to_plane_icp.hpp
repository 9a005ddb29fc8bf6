#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "worker/compare/m3c2.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::compare {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// Returns by how much a small rotation (rad) and shift (m) moves a point along a direction, per
// unit of each: [lever x direction, direction]. `lever_m` leads from the pivot to the point.
Vector6d motion_along(const Eigen::Vector3d& lever_m, const Eigen::Vector3d& direction);

// How much larger b is than a, as far as the aligned surfaces show it.
struct ScaleDifference {
    double value = 0.0;    // relative; positive if b is larger
    double sigma = 0.0;    // standard deviation, from the same patches as that of the pose
    double lever_m = 0.0;  // RMS change along the normal that a difference of 1 looks like
};

// The pose of b in a's frame, with its uncertainty.
struct CoRegistration {
    Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
    std::string method;            // markers, features, geometry: gave the coarse alignment
    double agreement = 0.0;        // share of b's points over a's ground that lie on its surface
    double tolerance_m = 0.0;      // max distance of a point "on" the surface
    double overlap = 0.0;          // share of b's points over a's ground
    double difference_m = 0.0;     // 80th percentile of the distance of b's points that lie on a
    double height_spread_m = 0.0;  // of these points, about their plane; 80th percentile as well
    double residual_rms_m = 0.0;   // of the points with weight, along the normal
    double stable_share = 0.0;     // share of the overlapping points with weight in the fit
    std::size_t num_patches = 0;   // independent ones, from which the uncertainty follows
    // Covariance of a small rotation (rad) and shift (m) of b about `pivot`, in a's frame: the
    // spread of the fit over patches with independent errors (sandwich estimator, Liang and Zeger
    // 1986).
    Matrix6d covariance = Matrix6d::Zero();
    Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
    std::optional<ScaleDifference> scale;  // nullopt: the surfaces do not show it
    types::SolverOutcome outcome;  // of ICP; costs: weighted mean square of the residuals, m^2

    // Returns the standard deviation along a direction at a point, m.
    double sigma_m(const Eigen::Vector3d& p, const Eigen::Vector3d& direction) const;
};

struct IcpOptions {
    double patch_m = 0.3;  // size of patches whose errors count as independent
    double tolerance_m = 0.02;
    double max_step_m = 0.3;  // of the first search; must cover the error of the coarse alignment
    int max_rounds = 40;
    int num_threads = 0;
};

// Aligns b's points with a's surface by point-to-plane ICP, starting at `T_a_b`. Points are
// weighted by their variances and robustly by Tukey's biweight, so that changed surface drops out;
// neighbours must face the same way. Returns nullopt if too few points find a partner.
std::optional<CoRegistration> point_to_plane_icp(const SurfacePoints& a,
                                                 const SurfacePoints& b,
                                                 const Eigen::Isometry3d& T_a_b,
                                                 const IcpOptions& options);

}  // namespace divemesh::compare
