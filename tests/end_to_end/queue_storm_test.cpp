#include "tests/end_to_end/queue_storm.hpp"

#include <gtest/gtest.h>

#include <gmock/gmock.h>

namespace divemesh {
namespace {

TEST(QueueStormTest, KillsOfWorkersAndServerLoseNoJobAndDoNoneTwice) {
    const StormReport report = run_queue_storm({.program = DIVEMESH_PROGRAM,
                                                .fake_worker = FAKE_WORKER,
                                                .num_jobs = 300,
                                                .num_workers = 3,
                                                .num_kills = 10});

    EXPECT_THAT(report.complaints, testing::IsEmpty());
    EXPECT_EQ(report.num_succeeded, 300);
    EXPECT_EQ(report.num_kills, 10);
}

}  // namespace
}  // namespace divemesh
