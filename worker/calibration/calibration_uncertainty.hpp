#pragma once

#include "worker/calibration/calibration_refinement.hpp"
#include "worker/optimisation/bundle_adjustment.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/rig_alignment.hpp"

namespace divemesh::calibration {

// Returns how uncertain the calibration is once `refined.calibration` is applied: both lenses, the
// rotation of the right camera, the length of the baseline, mounting and clock of the IMU. A
// parameter that the dive determined has the uncertainty of that estimate; an estimate that was not
// applied adds to its uncertainty. All others have that of a careful calibration, narrowed by what
// the alignment of the cameras determined of rows and disparities.
optimisation::CalibrationUncertainty calibration_uncertainty(const types::Rig& rig,
                                                             const types::RectifiedRig& rectified,
                                                             const CalibrationRefinement& refined,
                                                             const types::RigAlignment& alignment);

}  // namespace divemesh::calibration
