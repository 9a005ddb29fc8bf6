#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "schemas/content_hash.hpp"
#include "storage/event_store.hpp"
#include "tests/worker/runner/job_runner_fixture.hpp"

namespace divemesh::runner {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;
using testing::HasSubstr;

TEST_F(JobRunnerTest, TakesADiveThroughIntakeAndReconstruction) {
    const Job job = make_job("ok");
    Process worker = start_worker();

    ASSERT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();

    const Dive dive = dives_.get(job.dive_id);
    EXPECT_EQ(dive.state, DiveState::Ready);
    EXPECT_EQ(dive.name, "fake");
    EXPECT_TRUE(blobs_->exists(dives_.thumbnail_blob(dive.id)));
    const auto artifacts = jobs_.artifacts(job.id);
    ASSERT_EQ(artifacts.size(), 2u);
    EXPECT_EQ(artifacts[0].name, "keyframes/000001.jpg");
    EXPECT_EQ(artifacts[1].name, "mesh.ply");
    EXPECT_EQ(artifacts[1].sha256, sha256_hex("ply\n"));
    EXPECT_EQ(artifacts[1].media_type, "application/vnd.ply");
    EXPECT_TRUE(blobs_->exists(artifacts[1].blob));
    EXPECT_THAT(jobs_.log(job.id), HasSubstr("stage track"));
    worker.send(SIGTERM);
    EXPECT_EQ(worker.wait(seconds(30)), 0);
    EXPECT_TRUE(fs::is_empty(folder_ / "work"));
}

TEST_F(JobRunnerTest, AnAttemptThatTalksWithoutEndHoldsUpNothing) {
    const Job job = make_job("talk");
    Process worker = start_worker();
    ASSERT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();

    EXPECT_EQ(jobs_.get(job.id).progress.stage, "evaluate") << "the last word is never lost";
    EXPECT_LT(storage::EventStore(catalog_).newest_sequence(), 200);
}

// The message of a failure contains names from the recording.
TEST_F(JobRunnerTest, LogsOneLineForEachEventWhateverAMessageHolds) {
    const Job job = make_job("hostile");
    Process worker = start_worker();
    ASSERT_TRUE(reaches(job, JobState::Failed)) << worker.stderr_text();

    std::istringstream lines(worker.stdout_text());
    bool told = false;
    for (std::string line; std::getline(lines, line);) {
        const auto fields = nlohmann::json::parse(line.substr(line.find('{')), nullptr, false);
        ASSERT_FALSE(fields.is_discarded()) << line;
        told = told || fields.value("what", "").find("\n{\"event\"") != std::string::npos;
        EXPECT_EQ(line.find('\x1b'), std::string::npos) << line;
    }
    EXPECT_TRUE(told) << worker.stdout_text();
}

TEST_F(JobRunnerTest, TheStagesOfAnAttemptAreTold) {
    const Job job = make_job("ok");
    Process worker = start_worker();
    ASSERT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();

    const auto stages = jobs_.get(job.id).stages;
    ASSERT_EQ(stages.size(), 2u);
    EXPECT_EQ(stages[0].name, "evaluate");
    EXPECT_EQ(stages[1].name, "publish");
}

}  // namespace
}  // namespace divemesh::runner
