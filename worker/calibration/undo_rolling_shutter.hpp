#pragma once

#include <optional>
#include <vector>

#include "worker/camera/rolling_shutter.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/track.hpp"

namespace divemesh::calibration {

// Returns the motion at each of some frames of a track, by the odometry of the frames before and
// after it; nullopt where one of these motions was not measured or took more than 0.3 s.
std::vector<std::optional<camera::CameraMotion>> camera_motions(
    const types::Track& track, const std::vector<types::Keyframe>& frames);

// Moves every observation to where a global shutter would have seen the landmark at the time of the
// middle row.
void undo_rolling_shutter(const types::Rig& rig, double readout_time_s, types::Track& track);

}  // namespace divemesh::calibration
