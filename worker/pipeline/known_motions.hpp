#pragma once

#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/loops/drift_model.hpp"
#include "worker/optimisation/global_bundle_adjustment.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Returns the motions between consecutive keyframes that are known besides those by landmarks and
// IMU. Where the rig rested, the motion is the tracked one, with the sigma of the rest. Where too
// few landmarks connect two keyframes but every frame between them was tracked, it is the
// odometry's. Where the scene was lost and the IMU measured nothing, it is the predicted one, with
// the sigma of the drift model. `closed` has keyframes and odometry as they are now; rests and the
// motion over them are those of `track`.
std::vector<optimisation::KnownMotion> known_motions(const types::Track& track,
                                                     const types::Track& closed,
                                                     const imu::InertialPrior& inertial,
                                                     const loops::DriftModel& drift);

}  // namespace divemesh::pipeline
