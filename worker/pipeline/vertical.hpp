#pragma once

#include "worker/imu/inertial_prior.hpp"
#include "worker/types/optimised_track.hpp"

namespace divemesh::pipeline {

// Returns true if sensors measured which way is up: the accelerometer, the AHRS, or the pressure if
// the dive is one segment, was adjusted as a whole and its path spreads far enough in both
// horizontal directions. Otherwise the path and the surface are as if the first image were level.
bool vertical_is_known(const imu::InertialPrior& inertial, const types::OptimisedTrack& optimised);

}  // namespace divemesh::pipeline
