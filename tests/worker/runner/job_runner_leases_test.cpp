#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <gmock/gmock.h>
#include <string>
#include <thread>
#include <vector>

#include "storage/worker_store.hpp"
#include "tests/worker/runner/job_runner_fixture.hpp"

namespace divemesh::runner {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;
using testing::HasSubstr;

TEST_F(JobRunnerTest, AJobOfAKilledWorkerRunsAgain) {
    const Job job = make_job(wait_once());
    Process victim = start_worker();
    const pid_t child = child_of_marker();

    victim.kill();
    EXPECT_TRUE(is_gone(child)) << "a child outlived its worker";
    Process second = start_worker();

    ASSERT_TRUE(reaches(job, JobState::Succeeded)) << second.stderr_text();
    const auto attempts = jobs_.attempts(job.id);
    ASSERT_EQ(attempts.size(), 2u);
    EXPECT_EQ(attempts[0].state, AttemptState::LeaseLost);
    EXPECT_EQ(attempts[1].state, AttemptState::Succeeded);
    second.send(SIGTERM);
    EXPECT_EQ(second.wait(seconds(30)), 0);
    EXPECT_TRUE(fs::is_empty(folder_ / "work")) << "the killed worker's scratch is still there";
}

TEST_F(JobRunnerTest, AWorkerThatFrozeBeyondItsLeasePublishesNothing) {
    const Job job = make_job(wait_once());
    Process frozen = start_worker();
    const pid_t child = child_of_marker();

    freeze(frozen);
    Process second = start_worker();
    ASSERT_TRUE(reaches(job, JobState::Succeeded)) << second.stderr_text();
    let_go();  // now the first child succeeds as well, and its worker continues
    EXPECT_TRUE(is_gone(child));
    frozen.send(SIGCONT);
    frozen.send(SIGTERM);
    EXPECT_EQ(frozen.wait(seconds(30)), 0);

    const auto attempts = jobs_.attempts(job.id);
    ASSERT_EQ(attempts.size(), 2u);
    EXPECT_EQ(attempts[0].state, AttemptState::LeaseLost);
    EXPECT_EQ(attempts[1].state, AttemptState::Succeeded);
    EXPECT_EQ(num_blobs_of_jobs(), 2u);
    const auto artifacts = jobs_.artifacts(job.id);
    ASSERT_FALSE(artifacts.empty());
    for (const Artifact& artifact : artifacts) {
        EXPECT_THAT(artifact.blob, HasSubstr("attempt-2"));
        EXPECT_TRUE(blobs_->exists(artifact.blob));
    }
}

TEST_F(JobRunnerTest, AWorkerThatIsEndedGivesItsAttemptBack) {
    const Job job = make_job(wait_once());
    Process worker = start_worker();
    const pid_t child = child_of_marker();

    worker.send(SIGTERM);

    EXPECT_EQ(worker.wait(seconds(30)), 0);
    EXPECT_TRUE(is_gone(child));
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Queued);
    EXPECT_EQ(jobs_.get(job.id).num_attempts, 0);
    EXPECT_EQ(jobs_.attempts(job.id).at(0).state, AttemptState::Released);
}

TEST_F(JobRunnerTest, AWorkerThatDrainsFinishesWhatItHasAndTakesNothingMore) {
    const Job first = make_job(wait_once());
    Process worker = start_worker();
    child_of_marker();
    const Job second = make_job("ok");
    storage::WorkerStore workers(catalog_);
    const std::string name = workers.list().at(0).name;

    EXPECT_EQ(workers.set_draining(name, true).num_running, 1);
    let_go();
    ASSERT_TRUE(reaches(first, JobState::Succeeded)) << worker.stderr_text();
    EXPECT_TRUE(wait_until(seconds(30), [&] { return workers.list().at(0).num_running == 0; }));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));  // a few polls
    EXPECT_EQ(jobs_.get(second.id).num_attempts, 0);
    workers.set_draining(name, false);

    EXPECT_TRUE(reaches(second, JobState::Succeeded)) << worker.stderr_text();
    worker.send(SIGTERM);
    EXPECT_EQ(worker.wait(seconds(30)), 0);
    EXPECT_TRUE(workers.list().empty());
}

TEST_F(JobRunnerTest, TwoWorkersShareTheJobsAndEachRunsOnce) {
    std::vector<Job> made;
    for (int i = 0; i < 6; ++i) made.push_back(make_job("ok " + std::to_string(i)));
    Process first = start_worker();
    Process second = start_worker();

    for (const Job& job : made) {
        EXPECT_TRUE(reaches(job, JobState::Succeeded));
        EXPECT_EQ(jobs_.attempts(job.id).size(), 1u);
    }
}

}  // namespace
}  // namespace divemesh::runner
