#include "worker/pipeline/move_to_own_range.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/ideal_rig.hpp"

namespace divemesh::pipeline {
namespace {

// Shifts to the right by a tenth of the square root of the disparity.
types::RangeTable table() {
    types::RangeTable ranges{2, 2, 2, 639.0, 479.0, 20.0, {}};
    ranges.shifts_px.assign(8, Eigen::Vector3f::Zero());
    for (int row = 0; row < 2; ++row)
        for (int column = 0; column < 2; ++column)
            ranges.node(1, row, column) = Eigen::Vector3f(2.0F, 0.0F, 1.0F);
    return ranges;
}

TEST(MoveToOwnRangeTest, PixelsMoveByTheirDisparityOrByTheDepthOfTheirLandmark) {
    types::Track track;
    track.rig = synthetic::ideal_rig(640, 480, 500.0);
    track.keyframes.resize(2);
    types::Landmark landmark;
    // 25 px from the first keyframe, 100 px from nearer, where only the left camera sees it.
    landmark.p_world = {0.0, 0.0, track.rig.depth_m(25.0)};
    track.keyframes[1].T_world_cam.translation().z() =
        track.rig.depth_m(25.0) - track.rig.depth_m(100.0);
    landmark.observations = {{0, 300.0F, 200.0F, 25.0F}, {1, 310.0F, 210.0F, 0.0F}};
    track.landmarks = {landmark};

    move_to_own_range(table(), track);

    const auto& seen = track.landmarks[0].observations;
    EXPECT_NEAR(seen[0].u_px, 300.5F, 1e-4F);
    EXPECT_NEAR(seen[0].v_px, 200.0F, 1e-4F);
    EXPECT_EQ(seen[0].disparity_px, 25.0F);
    EXPECT_NEAR(seen[1].u_px, 311.0F, 1e-4F);
    EXPECT_EQ(seen[1].disparity_px, 0.0F);
}

}  // namespace
}  // namespace divemesh::pipeline
