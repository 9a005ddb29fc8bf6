#include <gtest/gtest.h>

#include <gmock/gmock.h>

#include "tests/worker/runner/job_runner_fixture.hpp"

namespace divemesh::runner {
namespace {

using testing::HasSubstr;

TEST_F(JobRunnerTest, ARunningJobIsCancelled) {
    const Job job = make_job(wait_once());
    Process worker = start_worker();
    const pid_t child = child_of_marker();

    jobs_.cancel(job.id);

    EXPECT_TRUE(reaches(job, JobState::Cancelled));
    EXPECT_TRUE(is_gone(child));
    EXPECT_EQ(jobs_.attempts(job.id).at(0).state, AttemptState::Cancelled);
    EXPECT_EQ(num_blobs_of_jobs(), 0u);
}

TEST_F(JobRunnerTest, AChildThatDoesNotListenIsKilled) {
    const Job job = make_job("deaf " + marker_.string());
    Process worker = start_worker();
    const pid_t child = child_of_marker();

    jobs_.cancel(job.id);

    EXPECT_TRUE(reaches(job, JobState::Cancelled));
    EXPECT_TRUE(is_gone(child));
}

TEST_F(JobRunnerTest, BadDataFailsAtOnceWithItsReason) {
    const Job job = make_job("bad");
    Process worker = start_worker();

    ASSERT_TRUE(reaches(job, JobState::Failed));
    EXPECT_EQ(jobs_.get(job.id).failure.code, ErrorCode::BadData);
    EXPECT_EQ(jobs_.get(job.id).failure.message, "mav0/cam1 is missing");
    EXPECT_EQ(jobs_.attempts(job.id).size(), 1u);
}

TEST_F(JobRunnerTest, AResultThatIsNotUsableFailsAndIsKept) {
    const Job job = make_job("unusable");
    Process worker = start_worker();

    ASSERT_TRUE(reaches(job, JobState::Failed));
    const Job failed = jobs_.get(job.id);
    EXPECT_EQ(verdict_of(failed), "not_usable");
    ASSERT_EQ(failed.findings.size(), 1U);
    EXPECT_EQ(failed.findings[0].code, "no_surface");
    EXPECT_THAT(failed.failure.message, HasSubstr("among the artifacts"));
    EXPECT_EQ(failed.failure.remedy, "swim");
    EXPECT_FALSE(jobs_.artifacts(job.id).empty());
    EXPECT_THAT(jobs_.log(job.id), HasSubstr("error no_surface: the mesh has no triangles"));
}

TEST_F(JobRunnerTest, AChildThatCrashesIsTriedAgainAndThenGivenUp) {
    const Job job = make_job("abort", 2);
    Process worker = start_worker();

    ASSERT_TRUE(reaches(job, JobState::Dead));
    EXPECT_EQ(jobs_.attempts(job.id).size(), 2u);
    EXPECT_THAT(jobs_.get(job.id).failure.message, HasSubstr("signal 6 (Aborted)"));
}

TEST_F(JobRunnerTest, AChildThatEndsWithoutAResultIsAFailure) {
    const Job vanished = make_job("exit", 1);
    const Job buggy = make_job("bug", 1);
    Process worker = start_worker();

    ASSERT_TRUE(reaches(vanished, JobState::Dead));
    EXPECT_THAT(jobs_.get(vanished.id).failure.message, HasSubstr("exit code 7"));
    ASSERT_TRUE(reaches(buggy, JobState::Dead));
    EXPECT_THAT(jobs_.get(buggy.id).failure.message, HasSubstr("index out of range"));
}

}  // namespace
}  // namespace divemesh::runner
