#include "worker/pipeline/stage_progress.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace divemesh::pipeline {
namespace {

TEST(StageProgress, TheWholeIsTheSumOfTheStagesShares) {
    std::vector<Progress> seen;
    StageProgress stages([&](const Progress& progress) { seen.push_back(progress); });

    const auto track = stages.begin("track", 0.6);
    track({.fraction = 0.5, .frames_done = 5, .num_frames = 10});
    EXPECT_EQ(seen.back().stage, "track");
    EXPECT_DOUBLE_EQ(seen.back().fraction, 0.3);
    EXPECT_EQ(seen.back().frames_done, 5);

    stages.begin("mesh", 0.4)({.fraction = 1.0});
    EXPECT_DOUBLE_EQ(seen.back().fraction, 1.0);
    stages.finish();
    EXPECT_DOUBLE_EQ(seen.back().fraction, 1.0);
}

TEST(StageProgress, NeverGoesBack) {
    double newest = 0.0;
    StageProgress stages([&](const Progress& progress) {
        EXPECT_GE(progress.fraction, newest);
        newest = progress.fraction;
    });
    for (const char* stage : {"track", "optimise", "fuse"}) {
        const auto report = stages.begin(stage, 1.0 / 3.0);
        for (const double fraction : {0.1, 0.7, 1.0}) report({.fraction = fraction});
    }
    stages.finish();
    EXPECT_DOUBLE_EQ(newest, 1.0);
}

TEST(StageProgress, WhatTheCallbackThrowsReachesTheStage) {
    StageProgress stages([](const Progress& progress) {
        if (progress.fraction > 0.1) throw Error(ErrorCode::Cancelled, "cancelled");
    });
    const auto report = stages.begin("track", 1.0);
    EXPECT_THROW(report({.fraction = 0.5}), Error);
}

}  // namespace
}  // namespace divemesh::pipeline
