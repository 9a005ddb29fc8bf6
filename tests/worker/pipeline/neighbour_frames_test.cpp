#include "worker/pipeline/neighbour_frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace divemesh::pipeline {
namespace {

// Frames along a straight line, 5 cm apart.
std::vector<types::Keyframe> swim(int num_frames) {
    std::vector<types::Keyframe> frames(static_cast<std::size_t>(num_frames));
    for (std::size_t i = 0; i < frames.size(); ++i) {
        frames[i].frame_index = static_cast<int>(i);
        frames[i].T_world_cam.translation().x() = 0.05 * static_cast<double>(i);
    }
    return frames;
}

TEST(NeighbourFrames, AreATenthOfTheDepthAwayOnBothSides) {
    auto taken = neighbour_frames(swim(40), 20, 2.0);  // a tenth of 2 m: four frames
    std::sort(taken.begin(), taken.end());
    EXPECT_EQ(taken, (std::vector<std::size_t>{15, 16, 24, 25}));
}

TEST(NeighbourFrames, AreOfOneSideAtTheEndOfADive) {
    const auto taken = neighbour_frames(swim(40), 0, 2.0);
    ASSERT_EQ(taken.size(), 2U);
    EXPECT_EQ(taken[0], 4U);
}

TEST(NeighbourFrames, AreNotOfAnotherSegmentNorLookAnotherWay) {
    auto frames = swim(40);
    for (std::size_t i = 21; i < frames.size(); ++i) frames[i].segment = 1;
    for (std::size_t i = 0; i < 20; ++i)
        frames[i].T_world_cam.linear() =
            Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY()).toRotationMatrix();
    EXPECT_TRUE(neighbour_frames(frames, 20, 2.0).empty());
}

TEST(NeighbourFrames, AreNoneOfARigAtRest) {
    EXPECT_TRUE(neighbour_frames(std::vector<types::Keyframe>(30), 15, 2.0).empty());
}

TEST(FramesApart, AreFourPerCentOfTheDepthApart) {
    EXPECT_EQ(frames_apart(swim(10), 2.4), (std::vector<std::size_t>{0, 2, 4, 6, 8}));
    EXPECT_EQ(frames_apart(std::vector<types::Keyframe>(30), 2.4), (std::vector<std::size_t>{0}));
}

TEST(FramesApart, AreTurned) {
    std::vector<types::Keyframe> frames(4);
    for (std::size_t i = 0; i < frames.size(); ++i)
        frames[i].T_world_cam.linear() =
            Eigen::AngleAxisd(0.05 * static_cast<double>(i), Eigen::Vector3d::UnitZ())
                .toRotationMatrix();
    EXPECT_EQ(frames_apart(frames, 2.4), (std::vector<std::size_t>{0, 2}));
}

}  // namespace
}  // namespace divemesh::pipeline
