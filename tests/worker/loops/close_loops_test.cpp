#include "worker/loops/close_loops.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/floor_swim.hpp"
#include "tests/synthetic/pose_near.hpp"
#include "worker/loops/find_loops.hpp"

namespace divemesh::loops {
namespace {

using synthetic::above_floor;
using synthetic::Path;
using synthetic::SeaFloor;

// Returns a path straight ahead, around a turn far from the start, and back home about 8 cm from
// the start.
Path there_and_back() {
    Path path;
    for (int i = 0; i < 12; ++i) path.push_back(above_floor(0.4 * i, 0.0, 0.0));
    for (int i = 0; i < 8; ++i) path.push_back(above_floor(4.4, 0.4 * (i + 1), 0.0));
    for (int i = 0; i < 12; ++i) path.push_back(above_floor(4.4 - 0.4 * i, 3.2, 0.0));
    for (int i = 0; i < 9; ++i) path.push_back(above_floor(0.0, 2.8 - 0.34 * i, 0.05));
    return path;
}

// A dive whose loops are closed.
struct Swim : synthetic::FloorSwim {
    using FloorSwim::FloorSwim;

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
    for (int i = 0; i < 22; ++i) straight.push_back(above_floor(0.25 * i, 0.0, 0.0));
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
