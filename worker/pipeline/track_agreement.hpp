#pragma once

#include <cstddef>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/track.hpp"
#include "worker/types/track_check.hpp"

namespace divemesh::pipeline {

// Returns how `now` agrees with its odometry and with what `tracked`, the track before loops were
// closed, saw itself: of each landmark the first observations, as many as it had there. Of every
// `landmark_stride`-th landmark, as they were adjusted. The odometry errs by `drift`.
types::TrackAgreement agreement(const types::Track& now,
                                const types::Track& tracked,
                                std::size_t landmark_stride,
                                const loops::DriftModel& drift);

// Returns how far keyframes of the first piece moved against the first keyframe, RMS, in standard
// deviations of both paths; 0 without covariances.
double moved_rms_sigmas(const std::vector<types::Keyframe>& before,
                        const std::vector<types::Keyframe>& after,
                        const types::CovarianceTrack& covariances,
                        const loops::DriftModel& drift);

// Returns whether the path contradicts the motion from frame to frame, or is not finite.
bool contradicts_odometry(const types::TrackCheck& check);

// Returns whether the track agrees with what was measured less than before, or moved further than
// it can have been off.
bool is_worse(const types::TrackCheck& check);

}  // namespace divemesh::pipeline
