#include "worker/pipeline/other_start.hpp"

#include <algorithm>

#include "worker/optimisation/follow_keyframes.hpp"

namespace divemesh::pipeline {

void start_from_odometry(types::Track& track) {
    for (types::Keyframe& keyframe : track.keyframes)
        keyframe.T_world_cam =
            track.odometry[optimisation::frame_at(track.odometry, keyframe.timestamp_ns)]
                .T_world_imu *
            track.rig.T_imu_cam;
    for (types::Landmark& landmark : track.landmarks) {
        const auto seen = std::ranges::find_if(
            landmark.observations,
            [](const types::LandmarkObservation& of) { return of.disparity_px > 0.0F; });
        if (seen == landmark.observations.end()) continue;
        landmark.p_world =
            track.keyframes[static_cast<std::size_t>(seen->keyframe)].T_world_cam *
            track.rig.point_cam(seen->u_px, seen->v_px, track.rig.depth_m(seen->disparity_px));
    }
}

}  // namespace divemesh::pipeline
