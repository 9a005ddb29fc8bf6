#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/optimisation/anchored_path.hpp"
#include "worker/types/path_prior.hpp"

namespace divemesh::optimisation {

// A point that moves with the path, and where another instrument measured it. Frame `site`: x east,
// y north, z up, m.
struct OutsidePoint {
    std::int64_t timestamp_ns = 0;                      // of the path that it moves with
    Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  // by the path as it is
    Eigen::Vector3d p_site = Eigen::Vector3d::Zero();   // measured
    double sigma_h_m = 0.0;                             // along x and y, each
    double sigma_v_m = 0.0;                             // 0: the height was not measured
    std::size_t source = 0;                             // its number among the sources
};

// A motion of the body from one anchor to the next, in the axes of the body at the first.
struct OutsideMotion {
    std::size_t from = 0;
    Eigen::Vector3d motion_imu = Eigen::Vector3d::Zero();
    double sigma_m = 0.0;  // of each axis
};

// States what is known beside the measurements.
struct JoinSettings {
    double tilt_sigma_rad = 0.01;         // of the world's vertical, each axis
    double scale_sigma = 0.0;             // of the error of the scale that all lengths share
    bool calibration_is_exact = false;    // leave out PathPrior::shared
    double prior_factor = 1.0;            // on the sigmas of the prior
    std::vector<double> offset_sigmas_m;  // of each source: horizontal, the same for all its points
};

// A path, and where it lies, by its prior and what other instruments measured.
struct JoinedPath {
    bool converged = false;  // the last step moved no unknown by more than 3 % of its sigma
    int num_iterations = 0;
    Eigen::Isometry3d T_site_world = Eigen::Isometry3d::Identity();
    // Covariance of the first pose in `site`: rotation vector, rad, then position, m.
    Eigen::Matrix<double, 6, 6> site_covariance = Eigen::Matrix<double, 6, 6>::Zero();
    // Correction of each anchor, to the world with its z axis along that of the site; the first
    // anchor stays where it is.
    std::vector<Eigen::Isometry3d> T_new_old;
    Eigen::MatrixXd prior_covariance;  // of the anchors, as PathPrior
    Eigen::MatrixXd covariance;        // the same, joined
    // By the factor that all lengths of the path have to be multiplied by, minus 1.
    double scale_error = 0.0;
    double scale_error_sigma = 0.0;
    // How far the measurements moved the path, in the sigmas of its prior: the largest along one of
    // its independent directions, and the sum of squares over all with the number of directions
    // that the measurements determine (redundancy; Foerstner 1979). Their ratio is about 1 if the
    // prior's sigmas are right.
    double moved_sigmas = 0.0;
    double moved_squares = 0.0;
    double num_determined = 0.0;
    // Residual of each point in `site`, m, measured minus path.
    std::vector<Eigen::Vector3d> residuals_m;
};

// Joins a path with points and motions that other instruments measured: the maximum a posteriori of
// Gaussian priors and of Student's t (4 degrees of freedom; Lange, Little and Taylor 1989) for the
// measurements, by iterative reweighting from wide to stated sigmas. Unknown are the rotation and
// the place of the world in `site`, the corrections of the anchors and the offsets of the sources.
// The corrections of the motions from anchor to anchor are small, and are chained, so the path may
// bend by any angle.
// `T_site_world` is the start. `prior` holds the anchors of `path`.
JoinedPath join_path(const AnchoredPath& path,
                     const types::PathPrior& prior,
                     const std::vector<OutsidePoint>& points,
                     const std::vector<OutsideMotion>& motions,
                     const Eigen::Isometry3d& T_site_world,
                     const JoinSettings& settings);

}  // namespace divemesh::optimisation
