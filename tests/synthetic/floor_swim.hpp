#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "tests/synthetic/sea_floor.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/types/track.hpp"

namespace divemesh::synthetic {

using Path = std::vector<Eigen::Isometry3d>;  // T_world_cam of each keyframe

// Returns a pose that looks straight down.
inline Eigen::Isometry3d above_floor(double x_m, double y_m, double yaw_rad) {
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    T_world_cam.translation() << x_m, y_m, 0.0;
    T_world_cam.rotate(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
    return T_world_cam;
}

// A dive over the floor as the result of a tracker: poses that drift along x by a share of the path
// length, one keyframe a second, and landmarks that live for three keyframes, observed without
// noise.
struct FloorSwim {
    // Renders the images from the poses `shown`, which differ from `path` where the floor has
    // moved.
    FloorSwim(const SeaFloor& floor, const Path& path, double drift, const Path& shown)
        : T_world_cam(path) {
        track.rig = small_rig();
        track.statistics.median_depth_m = SeaFloor::kDepth_m;
        double way_m = 0.0;
        for (std::size_t k = 0; k < path.size(); ++k) {
            if (k > 0) way_m += (path[k].translation() - path[k - 1].translation()).norm();
            types::Keyframe keyframe;
            keyframe.frame_index = static_cast<int>(k);
            keyframe.timestamp_ns = static_cast<std::int64_t>(k) * 1'000'000'000;
            keyframe.T_world_cam = path[k];
            keyframe.T_world_cam.translation().x() += drift * way_m;
            track.keyframes.push_back(keyframe);
            track.odometry.push_back(
                {keyframe.timestamp_ns, keyframe.T_world_cam * track.rig.T_imu_cam.inverse()});
            track.sigmas.push_back({0.01, 0.002});
            track.motions.push_back(types::MotionSource::Vision);
            keep_images(floor, shown[k], static_cast<int>(k));
            for (int i = 0; i < 80; ++i)
                start_landmark(k, 20.0 + 31.0 * (i % 10), 20.0 + 28.0 * (i / 10));
        }
        track.causal = track.odometry;
        track.mapped = track.keyframes;
    }
    FloorSwim(const SeaFloor& floor, const Path& path, double drift)
        : FloorSwim(floor, path, drift, path) {}

    // Returns u, v and disparity.
    Eigen::Vector3d true_px(std::size_t landmark, std::size_t keyframe) const {
        return types::project_px(track.rig, T_world_cam[keyframe].inverse() * p_true[landmark]);
    }

    TemporaryFolder folder;
    keyframes::KeyframeStore store{folder.path()};
    Path T_world_cam;                     // true
    std::vector<Eigen::Vector3d> p_true;  // landmarks, in the world
    types::Track track;

private:
    static constexpr std::size_t kLife = 3;  // keyframes

    void keep_images(const SeaFloor& floor, const Eigen::Isometry3d& seen_from, int frame_index) {
        const types::KeyframeImages images = floor.look(seen_from);
        cv::Mat left;
        cv::extractChannel(images.left_color, left, 0);
        store.write_left(frame_index, left);
        store.write_keypoints(frame_index, SeaFloor::view(seen_from, images));
    }

    void start_landmark(std::size_t k, double u_px, double v_px) {
        const Eigen::Vector3d p_cam = SeaFloor::seen_at(T_world_cam[k], u_px, v_px);
        p_true.push_back(T_world_cam[k] * p_cam);
        types::Landmark landmark;
        landmark.p_world = track.keyframes[k].T_world_cam * p_cam;
        for (std::size_t i = k; i < std::min(k + kLife, T_world_cam.size()); ++i) {
            const Eigen::Vector3d px = true_px(p_true.size() - 1, i);
            landmark.observations.push_back({static_cast<std::int32_t>(i),
                                             static_cast<float>(px.x()),
                                             static_cast<float>(px.y()),
                                             static_cast<float>(px.z())});
        }
        track.landmarks.push_back(landmark);
    }
};

}  // namespace divemesh::synthetic
