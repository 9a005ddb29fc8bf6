#include "worker/evaluation/tracking_segments.hpp"

#include <gtest/gtest.h>

namespace divemesh::evaluation {
namespace {

// Returns ten frames 0.1 m apart; the keyframes 0, 4 and 8 have the given segments.
types::Trajectory frames() {
    types::Trajectory trajectory;
    for (int i = 0; i < 10; ++i)
        trajectory.push_back({i, Eigen::Isometry3d(Eigen::Translation3d(0.1 * i, 0.0, 0.0))});
    return trajectory;
}

std::vector<types::Keyframe> keyframes(std::int32_t at_0, std::int32_t at_4, std::int32_t at_8) {
    return {{0, 0, Eigen::Isometry3d::Identity(), at_0},
            {4, 4, Eigen::Isometry3d::Identity(), at_4},
            {8, 8, Eigen::Isometry3d::Identity(), at_8}};
}

TEST(TrackingSegmentsTest, ADiveThatNeverLosesTheSceneIsOneSegment) {
    const auto segments = segments_of(frames(), keyframes(0, 0, 0));
    ASSERT_EQ(segments.size(), 1U);
    EXPECT_EQ(segments[0].num_frames, 10);
    EXPECT_EQ(segments[0].num_keyframes, 3);
    EXPECT_NEAR(segments[0].path_length_m, 0.9, 1e-12);
    EXPECT_EQ(segments_of(frames(), {}).size(), 1U);
}

TEST(TrackingSegmentsTest, ASegmentRejoinedByALoopHasTwoIntervals) {
    const auto segments = segments_of(frames(), keyframes(0, 1, 0));
    ASSERT_EQ(segments.size(), 2U);
    ASSERT_EQ(segments[0].intervals.size(), 2U);
    EXPECT_EQ(segments[0].intervals[0].last_ns, 3);
    EXPECT_EQ(segments[0].intervals[1].first_ns, 8);
    EXPECT_EQ(segments[0].num_frames, 6);
    EXPECT_EQ(segments[1].num_frames, 4);
    EXPECT_NEAR(segments[0].path_length_m, 0.4, 1e-12);  // the jump in between is not counted
}

TEST(TrackingSegmentsTest, AfterABreakFramesBelongToTheNextKeyframesSegment) {
    const auto segments = segments_of(frames(), keyframes(0, 1, 1), {2});
    ASSERT_EQ(segments.size(), 2U);
    EXPECT_EQ(segments[0].num_frames, 2);
    EXPECT_EQ(segments[1].intervals[0].first_ns, 2);
    EXPECT_NEAR(segments[1].path_length_m, 0.7, 1e-12);
}

TEST(TrackingSegmentsTest, UnmeasuredMotionAddsNoPathLength) {
    EXPECT_NEAR(segments_of(frames(), keyframes(0, 0, 0), {3, 6})[0].path_length_m, 0.7, 1e-12);
}

TEST(TrackingSegmentsTest, LargestSegmentHasTheMostFrames) {
    const types::Trajectory largest =
        within_largest(frames(), segments_of(frames(), keyframes(0, 1, 1)));
    ASSERT_EQ(largest.size(), 6U);
    EXPECT_EQ(largest.front().timestamp_ns, 4);
    EXPECT_EQ(within_largest(frames(), segments_of(frames(), keyframes(0, 0, 0))).size(), 10U);
    EXPECT_TRUE(within_largest({}, {}).empty());
}

TEST(TrackingSegmentsTest, WhatLiesBetweenTheIntervalsOfTheLargestSegmentIsNotPartOfIt) {
    const types::Trajectory largest =
        within_largest(frames(), segments_of(frames(), keyframes(0, 1, 0)));
    ASSERT_EQ(largest.size(), 6U);
    EXPECT_EQ(largest[3].timestamp_ns, 3);
    EXPECT_EQ(largest[4].timestamp_ns, 8);
}

}  // namespace
}  // namespace divemesh::evaluation
