#pragma once

#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/types/motion_sigma.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Returns how well a motion over `interval_s` is known: by step 6 over the inliers of `vision` and
// the known rotation, or, if vision found none, as a random walk of a tenth of a metre in a second.
types::MotionSigma sigma_of_motion(const types::RectifiedRig& rig,
                                   const Registration& vision,
                                   const MotionGuess& motion,
                                   double interval_s);

}  // namespace divemesh::odometry
