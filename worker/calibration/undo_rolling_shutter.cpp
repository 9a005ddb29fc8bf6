#include "worker/calibration/undo_rolling_shutter.hpp"

#include <algorithm>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"

namespace divemesh::calibration {
namespace {

constexpr double kMaxInterval_s = 0.3;  // for which a motion counts as uniform

}  // namespace

std::vector<std::optional<camera::CameraMotion>> camera_motions(
    const types::Track& track, const std::vector<types::Keyframe>& frames) {
    const types::Trajectory& path = track.odometry;
    const auto is_short = [&](std::size_t frame) {
        return base::to_s(path[frame].timestamp_ns - path[frame - 1].timestamp_ns) <=
                   kMaxInterval_s &&
               !types::is_break(track.breaks_ns, path[frame].timestamp_ns);
    };
    std::vector<std::optional<camera::CameraMotion>> motions;
    for (const types::Keyframe& keyframe : frames) {
        motions.emplace_back();
        const auto at = std::ranges::lower_bound(
            path, keyframe.timestamp_ns, {}, &types::StampedPose::timestamp_ns);
        const auto frame = static_cast<std::size_t>(at - path.begin());
        if (frame == 0 || frame + 1 >= path.size() || !is_short(frame) || !is_short(frame + 1))
            continue;
        const Eigen::Isometry3d before = path[frame - 1].T_world_imu * track.rig.T_imu_cam;
        const Eigen::Isometry3d after = path[frame + 1].T_world_imu * track.rig.T_imu_cam;
        const Eigen::Isometry3d T_cam_world =
            (path[frame].T_world_imu * track.rig.T_imu_cam).inverse();
        const double duration_s =
            base::to_s(path[frame + 1].timestamp_ns - path[frame - 1].timestamp_ns);
        motions.back() = camera::CameraMotion{
            base::vector_from_rotation(
                Eigen::Quaterniond(before.linear().transpose() * after.linear())) /
                duration_s,
            T_cam_world.linear() * (after.translation() - before.translation()) / duration_s};
    }
    return motions;
}

void undo_rolling_shutter(const types::Rig& rig, double readout_time_s, types::Track& track) {
    const auto motions = camera_motions(track, track.keyframes);
    const camera::RollingShutter shutter(track.rig, camera::rectified_lenses(rig)[0]);
    for (types::Landmark& landmark : track.landmarks) {
        for (types::LandmarkObservation& seen : landmark.observations) {
            const auto keyframe = static_cast<std::size_t>(seen.keyframe);
            if (!motions[keyframe]) continue;
            const Eigen::Vector3f shift_px =
                (readout_time_s *
                 shutter.shift_px_s(
                     *motions[keyframe],
                     {seen.u_px, seen.v_px},
                     track.keyframes[keyframe].T_world_cam.inverse() * landmark.p_world))
                    .cast<float>();
            seen.u_px -= shift_px.x();
            seen.v_px -= shift_px.y();
            if (seen.disparity_px > 0.0F) seen.disparity_px -= shift_px.z();
        }
    }
}

}  // namespace divemesh::calibration
