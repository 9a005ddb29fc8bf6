#include "schemas/job_state.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh {
namespace {

TEST(JobState, EveryStateSurvivesTheWayThroughText) {
    for (const JobState state : kJobStates)
        EXPECT_EQ(job_state_from_string(to_string(state)), state);
    EXPECT_THROW(job_state_from_string("done"), Error);
}

TEST(JobState, ASucceededJobNeverChanges) {
    for (const JobState to : kJobStates) EXPECT_FALSE(can_transition(JobState::Succeeded, to));
}

TEST(JobState, OnlyARunningJobSucceedsOrDies) {
    for (const JobState from : kJobStates) {
        EXPECT_EQ(can_transition(from, JobState::Succeeded), from == JobState::Running);
        EXPECT_EQ(can_transition(from, JobState::Dead), from == JobState::Running);
    }
}

}  // namespace
}  // namespace divemesh
