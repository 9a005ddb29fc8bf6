#pragma once

#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/loops/drift_model.hpp"
#include "worker/optimisation/global_bundle_adjustment.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Returns what is known of the motions between keyframes beside landmarks and IMU: where the rig
// rested, as the rest tells; where the scene was lost and no IMU measured either, as predicted.
// `closed` holds the keyframes as they are now, `track` the rest.
std::vector<optimisation::KnownMotion> known_motions(const types::Track& track,
                                                     const types::Track& closed,
                                                     const imu::InertialPrior& inertial,
                                                     const loops::DriftModel& drift);

}  // namespace divemesh::pipeline
