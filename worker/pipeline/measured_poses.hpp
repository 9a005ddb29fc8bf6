#pragma once

#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/types/breaks.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/track.hpp"

// Which poses of a dive were measured, and which are predictions of the motion model.
namespace divemesh::pipeline {

// Counts short losses of vision as bridged by the IMU: of at most a second, between two motions
// that vision measured, if the IMU predicted every motion between them from a known velocity and
// covers them as a whole. All others are not measured. A second of integration errs by less than
// two centimetres; longer bridges join segments (loops::DriftModel), but the poses on them are
// predictions.
void bridge_by_imu(const imu::InertialPrior& inertial, types::Track& track);

// Returns the frames, after the first, whose motion was not measured.
types::Breaks breaks_of(const types::Track& track);

// Returns for each frame whether its pose was measured: motions that were measured, one at least,
// tie it to a keyframe. A dive of a single frame has no motion, and its pose is the origin.
std::vector<bool> measured_frames(const types::Trajectory& frames,
                                  const types::Breaks& breaks_ns,
                                  const std::vector<types::Keyframe>& keyframes);

// Returns the causal poses that were measured.
types::Trajectory measured_causal(const types::Track& track);

// Removes the keyframes whose pose was not measured, such as the first frame of a dive that begins
// in the dark, with their observations, and the mapped frames of that kind.
void drop_unmeasured_keyframes(types::Track& track);

// Moves the poses that were not measured from `trajectory` to `predicted`, and removes their
// covariances and mapped frames.
void set_predicted_apart(types::OptimisedTrack& result);

}  // namespace divemesh::pipeline
