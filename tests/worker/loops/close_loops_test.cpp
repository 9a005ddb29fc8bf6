#include "worker/loops/close_loops.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/sea_floor.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/loops/find_loops.hpp"

namespace divemesh::loops {
namespace {

using synthetic::SeaFloor;
using Path = std::vector<Eigen::Isometry3d>;

Eigen::Isometry3d above(double x_m, double y_m, double yaw_rad) {
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    T_world_cam.translation() << x_m, y_m, 0.0;
    T_world_cam.rotate(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
    return T_world_cam;
}

// Returns a path straight ahead, around a turn far from the start, and back home about 8 cm from
// the start.
Path there_and_back() {
    Path path;
    for (int i = 0; i < 12; ++i) path.push_back(above(0.4 * i, 0.0, 0.0));
    for (int i = 0; i < 8; ++i) path.push_back(above(4.4, 0.4 * (i + 1), 0.0));
    for (int i = 0; i < 12; ++i) path.push_back(above(4.4 - 0.4 * i, 3.2, 0.0));
    for (int i = 0; i < 9; ++i) path.push_back(above(0.0, 2.8 - 0.34 * i, 0.05));
    return path;
}

// A dive over the floor as a tracker passes it on: poses that drift along x, and landmarks that
// live for kLife keyframes, measured without noise.
struct Swim {
    Swim(const SeaFloor& floor, const Path& path, double drift) : T_world_cam(path) {
        constexpr int kLife = 3;
        track.rig = synthetic::small_rig();
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
            const types::KeyframeImages images = floor.look(path[k]);
            cv::Mat left;
            cv::extractChannel(images.left_color, left, 0);
            store.write_left(static_cast<int>(k), left);
            store.write_keypoints(static_cast<int>(k), SeaFloor::view(path[k], images));
            for (int i = 0; i < 80; ++i)
                start_landmark(k, 20.0 + 31.0 * (i % 10), 20.0 + 28.0 * (i / 10), kLife);
        }
    }

    void start_landmark(std::size_t k, double u_px, double v_px, std::size_t life) {
        const Eigen::Vector3d p_cam = SeaFloor::seen_at(T_world_cam[k], u_px, v_px);
        p_true.push_back(T_world_cam[k] * p_cam);
        types::Landmark landmark;
        landmark.p_world = track.keyframes[k].T_world_cam * p_cam;
        for (std::size_t i = k; i < std::min(k + life, T_world_cam.size()); ++i) {
            const Eigen::Vector3d px = true_px(p_true.size() - 1, i);
            landmark.observations.push_back({static_cast<std::int32_t>(i),
                                             static_cast<float>(px.x()),
                                             static_cast<float>(px.y()),
                                             static_cast<float>(px.z())});
        }
        track.landmarks.push_back(landmark);
    }

    Eigen::Vector3d true_px(std::size_t landmark, std::size_t keyframe) const {
        return types::project_px(track.rig, T_world_cam[keyframe].inverse() * p_true[landmark]);
    }

    types::LoopStatistics close() {
        keyframes = track.keyframes;
        landmarks = track.landmarks;
        const DriftModel drift(keyframes, landmarks, nullptr);
        const FoundLoops found = find_loops(track, drift, store, 1, base::ignore_progress);
        close_loops(track.rig, found.loops, drift, keyframes, landmarks);
        return found.statistics;
    }

    // Returns the RMS error and the number of the observations that the loops added.
    std::pair<double, int> error_of_new_observations_px() const {
        double squares = 0.0;
        int num = 0;
        for (std::size_t i = 0; i < landmarks.size(); ++i) {
            const auto& seen = landmarks[i].observations;
            for (std::size_t j = track.landmarks[i].observations.size(); j < seen.size(); ++j) {
                const Eigen::Vector3d px = true_px(i, static_cast<std::size_t>(seen[j].keyframe));
                squares +=
                    (px.head<2>() - Eigen::Vector2d(seen[j].u_px, seen[j].v_px)).squaredNorm();
                ++num;
            }
        }
        return {std::sqrt(squares / std::max(1, num)), num};
    }

    TemporaryFolder folder;
    keyframes::KeyframeStore store{folder.path()};
    Path T_world_cam;                     // true
    std::vector<Eigen::Vector3d> p_true;  // landmarks, in the world
    types::Track track;
    std::vector<types::Keyframe> keyframes;
    std::vector<types::Landmark> landmarks;
};

TEST(CloseLoopsTest, LandmarksOfBothVisitsAreSeenAgainWhereTheyAre) {
    Swim swim(SeaFloor(), there_and_back(), 0.001);
    const types::LoopStatistics loops = swim.close();
    EXPECT_GE(loops.num_accepted, 3);
    const auto [rms_px, num] = swim.error_of_new_observations_px();
    EXPECT_GE(num, 100);
    EXPECT_LT(rms_px, 0.2);
}

TEST(CloseLoopsTest, ATrackThatHasRunFarOffIsBroughtBackFirst) {
    Swim swim(SeaFloor(), there_and_back(), 0.02);
    const types::LoopStatistics loops = swim.close();
    EXPECT_GE(loops.num_accepted, 3);
    EXPECT_GT(loops.largest_correction_m, 0.15);
    EXPECT_LT(
        (swim.keyframes.back().T_world_cam.translation() - swim.T_world_cam.back().translation())
            .norm(),
        0.06);  // 0.27 m before
}

TEST(CloseLoopsTest, PlacesThatLookTheSameAreNotJoined) {
    Path straight;
    for (int i = 0; i < 22; ++i) straight.push_back(above(0.25 * i, 0.0, 0.0));
    Swim swim(SeaFloor(1.5), straight, 0.001);
    const types::LoopStatistics loops = swim.close();
    EXPECT_GT(loops.num_matched, 0);  // the images are the same
    EXPECT_EQ(loops.num_accepted, 0);
    EXPECT_EQ(swim.error_of_new_observations_px().second, 0);
}

TEST(CloseLoopsTest, GivesTheSameBitsAgain) {
    Swim swim(SeaFloor(), there_and_back(), 0.02);
    swim.close();
    const Eigen::Isometry3d once = swim.keyframes.back().T_world_cam;
    swim.close();
    EXPECT_EQ(swim.keyframes.back().T_world_cam.matrix(), once.matrix());
}

}  // namespace
}  // namespace divemesh::loops
