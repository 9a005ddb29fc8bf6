#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "worker/compare/m3c2.hpp"

namespace divemesh::compare {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Where b lies in a's frame, and how well that is known.
struct CoRegistration {
    Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
    std::string method;            // markers, features, geometry: what found the place
    double agreement = 0.0;        // share of b's points over a's ground that lie on its surface
    double tolerance_m = 0.0;      // what "on" means
    double overlap = 0.0;          // share of b's points over a's ground
    double difference_m = 0.0;     // of b's points that lie on a: four fifths are no farther off
    double height_spread_m = 0.0;  // of these points, about their plane; likewise
    double residual_rms_m = 0.0;   // of the points that count, along the normal
    double stable_share = 0.0;     // of the overlapping points: counts in the fit
    std::size_t num_patches = 0;   // independent ones, of which the uncertainty comes
    // Of a small turn (rad) and shift (m) of b about `pivot`, in a's frame: the spread of the fit
    // over patches that err independently (sandwich estimator, Liang and Zeger 1986).
    Matrix6d covariance = Matrix6d::Zero();
    Eigen::Vector3d pivot = Eigen::Vector3d::Zero();

    // Standard deviation along a direction at a place, m.
    double sigma_m(const Eigen::Vector3d& p, const Eigen::Vector3d& direction) const;
};

struct IcpOptions {
    double patch_m = 0.3;  // errors of patches this large count as independent
    double tolerance_m = 0.02;
    double max_step_m = 0.3;  // of the first search; must cover the error of the first guess
    int num_threads = 0;
};

// Point-to-plane ICP of b's points onto a's surface from a first guess. Weighted by the points' own
// variances and robust by Tukey's biweight, so that surface which has changed falls out; neighbours
// must face the same way. Nothing when too few points find a partner.
std::optional<CoRegistration> point_to_plane_icp(const SurfacePoints& a,
                                                 const SurfacePoints& b,
                                                 const Eigen::Isometry3d& T_a_b,
                                                 const IcpOptions& options);

}  // namespace divemesh::compare
