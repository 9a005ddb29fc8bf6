#pragma once

#include <functional>
#include <map>
#include <vector>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/stereo_world.hpp"
#include "worker/types/track.hpp"

namespace divemesh::synthetic {

// Returns T_world_cam at a frame, ten frames per second.
using PathOfFrames = std::function<Eigen::Isometry3d(double frame)>;

// Returns the result of a tracker on a path, by default that of stereo_world.hpp: odometry without
// error, every fifth frame a keyframe, and true landmarks observed with the noise of features.
inline types::Track tracked_dive(int num_keyframes, const PathOfFrames& path = T_world_cam) {
    constexpr int kStep = 5;
    constexpr double kNoise_px = 0.25;
    World world(0.03 * kStep * num_keyframes, 0.0, 1);
    types::Track track;
    track.rig = rig();
    std::map<std::int64_t, types::Landmark> seen;
    for (int frame = 0; frame <= kStep * (num_keyframes - 1); ++frame) {
        const std::int64_t timestamp_ns = 100'000'000LL * frame;
        const Eigen::Isometry3d T_world_camera = path(frame);
        const Eigen::Isometry3d T_world_imu = T_world_camera * track.rig.T_imu_cam.inverse();
        track.odometry.push_back({timestamp_ns, T_world_imu});
        track.sigmas.push_back({0.001, 0.0005});
        track.motions.push_back(types::MotionSource::Vision);
        if (frame % kStep != 0) continue;
        for (types::Feature feature : world.see(T_world_camera, frame, 0.0)) {
            types::Landmark& landmark = seen[feature.id];
            if (landmark.observations.empty())
                landmark.p_world = T_world_camera * types::point_cam(track.rig, feature);
            feature.pixel += kNoise_px * Eigen::Vector2d(world.normal(), world.normal());
            feature.disparity_px += kNoise_px * world.normal();
            landmark.observations.push_back({static_cast<std::int32_t>(track.keyframes.size()),
                                             static_cast<float>(feature.pixel.x()),
                                             static_cast<float>(feature.pixel.y()),
                                             static_cast<float>(feature.disparity_px)});
        }
        track.keyframes.push_back({frame, timestamp_ns, T_world_camera});
    }
    for (auto& [id, landmark] : seen)
        if (landmark.observations.size() > 1) track.landmarks.push_back(std::move(landmark));
    track.causal = track.odometry;
    track.mapped = track.keyframes;
    track.statistics.num_frames = std::ssize(track.odometry);
    track.statistics.num_frames_tracked = track.statistics.num_frames;
    track.statistics.median_depth_m = 2.0;
    return track;
}

}  // namespace divemesh::synthetic
