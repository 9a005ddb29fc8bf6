#pragma once

#include <cstddef>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/track.hpp"
#include "worker/types/track_check.hpp"

namespace divemesh::pipeline {

// Returns how well `now` agrees with its odometry, whose error is given by `drift`, and with its
// own observations. `tracked` is the track before loops were closed: of each landmark only the
// observations that it has there are used, which come first. Only every `landmark_stride`-th
// landmark is used, as in the bundle adjustment.
types::TrackAgreement agreement(const types::Track& now,
                                const types::Track& tracked,
                                std::size_t landmark_stride,
                                const loops::DriftModel& drift);

// Returns the RMS distance that the keyframes of the first segment moved relative to the first
// keyframe, in standard deviations of both paths; of the track's drift alone without covariances.
double moved_rms_sigmas(const std::vector<types::Keyframe>& before,
                        const std::vector<types::Keyframe>& after,
                        const types::CovarianceTrack& covariances,
                        const loops::DriftModel& drift);

// Returns true if the path contradicts the frame-to-frame motion, or is not finite.
bool contradicts_odometry(const types::TrackCheck& check);

// Returns true if the track agrees less with the measurements than before, or moved further than
// its drift explains.
bool is_worse(const types::TrackCheck& check);

}  // namespace divemesh::pipeline
