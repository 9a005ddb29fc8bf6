#pragma once

#include <vector>

#include "worker/base/observer.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/types/refined_calibration.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track.hpp"

namespace divemesh::calibration {

struct CalibrationRefinement {
    types::RefinedCalibration calibration;
    std::vector<types::SolverOutcome> solves;  // empty: there was too little to estimate it from
};

// Bundle adjustment with the calibration free, over keyframes and evenly thinned landmarks: time
// offset and rotation of the inertial unit by its gyroscope, focal length, principal point, k1 and
// k2 of both lenses by the pictures as they were recorded, each with a prior as wide as a careful
// calibration errs. A change is believed when it is significant and large enough to matter: a good
// calibration stays as it is, and so does one that a failed solver gives.
CalibrationRefinement refine_calibration(const types::Track& track,
                                         const types::Recording& recording,
                                         const ReconstructionOptions& options,
                                         const imu::InertialPrior& inertial,
                                         const base::ProgressCallback& progress,
                                         const Progress& at);

// Changes the track to what it would be with the refined calibration: body, odometry and
// observations. The camera poses stay.
void apply_calibration(const types::Rig& rig,
                       const types::RefinedCalibration& calibration,
                       types::Track& track);

}  // namespace divemesh::calibration
