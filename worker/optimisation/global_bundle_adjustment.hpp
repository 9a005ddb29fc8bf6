#pragma once

#include <cstddef>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/landmark.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track.hpp"

namespace divemesh::optimisation {

// The result of the bundle adjustment of a whole dive.
struct GlobalBundleAdjustment {
    double reprojection_rms_px = 0.0;
    types::CovarianceTrack
        covariances;              // of keyframes all along; empty when they are not determined
    types::PathUncertainty path;  // of the keyframes' positions
    types::SolverOutcome outcome;
    std::size_t landmark_stride = 1;  // of the landmarks that were adjusted
};

// All keyframes and landmarks of a dive adjusted together, with what the gyroscope says between
// keyframes and, weakly, the AHRS at them. The first keyframe stays where it is. Landmarks are
// thinned evenly so that an hour's dive stays solvable.
GlobalBundleAdjustment adjust_globally(const types::RectifiedRig& rig,
                                       const imu::InertialPrior& inertial,
                                       std::vector<types::Keyframe>& keyframes,
                                       std::vector<types::Landmark>& landmarks,
                                       const base::ProgressCallback& progress,
                                       const Progress& at);

}  // namespace divemesh::optimisation
