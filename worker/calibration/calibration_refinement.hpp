#pragma once

#include <vector>

#include "worker/base/observer.hpp"
#include "worker/calibration/calibration_priors.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/types/refined_calibration.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track.hpp"

namespace divemesh::calibration {

// The calibration, and how the solvers that estimated it ended.
struct CalibrationRefinement {
    types::RefinedCalibration calibration;
    LensCovariance lens_covariance = LensCovariance::Zero();  // of calibration.lenses
    std::vector<types::SolverOutcome> solves;                 // empty: too few data to estimate it
};

// Returns the calibration by a bundle adjustment over keyframes and evenly thinned landmarks with
// the calibration free: time offset and rotation of the IMU by its gyroscope; focal length,
// principal point, k1 and k2 of both lenses by the images as recorded, then with them the readout
// time of a rolling shutter. Each has a prior as wide as the error of a careful calibration, and
// the principal points as wide as `alignment` found an image shifted. All lens parameters are
// applied together, because a part of them would be wrong without the rest. A change is applied
// only if it is significant and its solve succeeded.
CalibrationRefinement refine_calibration(const types::Track& track,
                                         const types::Recording& recording,
                                         const ReconstructionOptions& options,
                                         const types::RigAlignment& alignment,
                                         const imu::InertialPrior& inertial,
                                         const base::ProgressCallback& progress,
                                         const Progress& at);

// Returns the rig with what is applied of the refined calibration.
types::Rig refined_rig(const types::Rig& rig, const types::RefinedCalibration& calibration);

// Changes the track to what it would be with the refined calibration: body, odometry and
// observations. The camera poses stay.
void apply_calibration(const types::Rig& rig,
                       const types::RefinedCalibration& calibration,
                       types::Track& track);

}  // namespace divemesh::calibration
