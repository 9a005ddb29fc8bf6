#pragma once

#include <cstddef>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/optimisation/bundle_adjustment.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/landmark.hpp"
#include "worker/types/path_prior.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track.hpp"

namespace divemesh::optimisation {

// The result of the bundle adjustment of a whole dive.
struct GlobalBundleAdjustment {
    double reprojection_rms_px = 0.0;
    types::CovarianceTrack covariances;  // of keyframes over the whole dive; empty: not determined
    types::CovarianceTrack drift;        // the same with the calibration taken as exact
    types::PathUncertainty path;         // of the keyframes' positions
    types::SolverOutcome outcome;
    std::size_t landmark_stride = 1;  // every n-th landmark was adjusted
    types::PathPrior prior;           // empty unless asked for
};

// Whether the joint covariance of keyframes is wanted, to be joined with measurements of where the
// dive took place.
enum class WithPrior { No, Yes };

// The motion of the body to a keyframe from the one before, known otherwise than by landmarks and
// inertial sensors: from a rest, or predicted where nothing measured it.
struct KnownMotion {
    std::size_t to = 0;
    Eigen::Isometry3d T_before_to = Eigen::Isometry3d::Identity();
    double sigma_m = 0.0;  // along each axis
    double sigma_rad = 0.0;
};

// Adjusts all keyframes and landmarks of a track together, with the inertial sensors between
// keyframes and, weakly, the AHRS at them. The first keyframe stays fixed. Landmarks are thinned
// evenly, so that an hour-long dive can be solved. Known motions hold a rig at rest together, and
// tie what nothing else ties, so that the covariance grows over a predicted motion as the motion
// model's does. The calibration is held; its uncertainty is part of the covariance.
GlobalBundleAdjustment adjust_globally(types::Track& track,
                                       const imu::InertialPrior& inertial,
                                       const std::vector<KnownMotion>& known,
                                       const CalibrationUncertainty& calibration,
                                       const base::ProgressCallback& progress,
                                       const Progress& at,
                                       WithPrior with_prior = WithPrior::No);

}  // namespace divemesh::optimisation
