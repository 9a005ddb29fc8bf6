#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <gmock/gmock.h>
#include <sstream>
#include <string>
#include <unistd.h>

#include "tests/small_disk.hpp"
#include "tests/worker/runner/job_runner_fixture.hpp"

namespace divemesh::runner {
namespace {

using std::chrono::seconds;
using testing::HasSubstr;

TEST_F(JobRunnerTest, BeginsNothingOnADiskThatIsNearlyFull) {
    const Job job = make_job("ok");
    {
        Process worker = start_worker("600000", "1000000000", "1000000000", "4000000000000000000");
        ASSERT_TRUE(wait_until(seconds(10), [&] {
            return worker.stdout_text().find("worker_waits") != std::string::npos;
        }));
        EXPECT_EQ(jobs_.get(job.id).state, JobState::Held);
        EXPECT_EQ(dives_.get(job.dive_id).state, DiveState::Checking);
    }
    Process worker = start_worker();
    EXPECT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();
}

TEST_F(JobRunnerTest, TheCacheGivesWayToAnAttemptOnADiskThatIsNearlyFull) {
    const SmallDisk disk(100);
    if (!disk.mounted()) GTEST_SKIP() << "needs the right to mount a tmpfs";
    work_folder_ = disk.path() / "work";
    const auto entry = disk.path() / "work-cache" / "track-1";
    disk.write(entry / "track.stage", 60);
    std::ofstream(entry / "files.json") << "[]";
    const Job job = make_job("ok");
    Process worker = start_worker("600000", "1000000000", "1000000000", "1048576");

    EXPECT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();
    EXPECT_FALSE(std::filesystem::exists(entry));
}

TEST_F(JobRunnerTest, AnAttemptMayUseTheSpaceOfTheCache) {
    const SmallDisk disk(200);
    if (!disk.mounted()) GTEST_SKIP() << "needs the right to mount a tmpfs";
    work_folder_ = disk.path() / "work";
    const auto entry = disk.path() / "work-cache" / "track-1";
    disk.write(entry / "track.stage", 100);
    std::ofstream(entry / "files.json") << "[]";
    const Job job = make_job("limits");
    Process worker = start_worker("600000", "1000000000", "0", "1048576");
    ASSERT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();

    std::istringstream limits(
        read_text(blobs_->local_copy(jobs_.artifact(job.id, "limits.txt").blob, folder_.path())));
    std::int64_t memory = 0, file = 0;
    limits >> memory >> file;
    EXPECT_GT(file, std::int64_t{160} << 20);  // 0.9 of what the disk has beyond --min-free
}

TEST_F(JobRunnerTest, AnAttemptPastItsDeadlineIsEnded) {
    // The deadline is that of the intake as well, which is not to exceed it on a busy machine.
    const Job job = make_job("deaf " + marker_.string(), 1);
    Process worker = start_worker("3000");

    EXPECT_TRUE(reaches(job, JobState::Dead));
    EXPECT_THAT(jobs_.get(job.id).failure.message, HasSubstr("deadline"));
}

TEST_F(JobRunnerTest, ADiskThatFillsWhileArtifactsAreWrittenLeavesNoneOfThem) {
    const Job job = make_job("large", 1);
    Process worker = start_worker("600000", "33554432");

    ASSERT_TRUE(reaches(job, JobState::Dead)) << worker.stderr_text();
    EXPECT_EQ(jobs_.get(job.id).failure.code, ErrorCode::OutOfSpace);
    EXPECT_TRUE(jobs_.artifacts(job.id).empty());
    EXPECT_EQ(num_blobs_of_jobs(), 0u);
}

TEST_F(JobRunnerTest, AJobThatIsKilledForItsMemoryRunsOnceMoreWithLess) {
    const Job killed = make_job("killed", 10);
    const Job greedy = make_job("greedy " + marker_.string(), 10);
    Process worker = start_worker();

    ASSERT_TRUE(reaches(killed, JobState::Dead)) << worker.stderr_text();
    EXPECT_EQ(jobs_.get(killed.id).failure.code, ErrorCode::OutOfMemory);
    EXPECT_EQ(jobs_.attempts(killed.id).size(), 2u);
    ASSERT_TRUE(reaches(greedy, JobState::Dead)) << worker.stderr_text();
    EXPECT_EQ(jobs_.get(greedy.id).failure.code, ErrorCode::OutOfMemory);
    EXPECT_EQ(read_text(marker_), "0 1073741824\n1 67108864\n");  // the second: one thread
}

TEST_F(JobRunnerTest, AnAttemptThatTakesMoreScratchThanItMayIsEnded) {
    const Job job = make_job("fill", 1);
    Process worker = start_worker("600000", "1000000000", "4194304");

    ASSERT_TRUE(reaches(job, JobState::Dead)) << worker.stderr_text();
    EXPECT_EQ(jobs_.get(job.id).failure.code, ErrorCode::OutOfSpace);
}

TEST_F(JobRunnerTest, AnAttemptHasLimitsAndNoNetworkNoKeysAndStartsNothing) {
    for (const char* name :
         {"AWS_SECRET_ACCESS_KEY", "PGPASSWORD", "DIVEMESH_CATALOG", "DIVEMESH_TOKEN"})
        setenv(name, "secret", 1);  // the worker gets it
    const Job job = make_job("limits");
    Process worker = start_worker("600000", "1000000000", "123456789");
    ASSERT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();

    std::istringstream limits(
        read_text(blobs_->local_copy(jobs_.artifact(job.id, "limits.txt").blob, folder_.path())));
    std::int64_t memory = 0, file = 0, open_files = 0, cpu_s = 0, cache = 0;
    std::string cache_name;
    std::string network;
    std::string processes;
    std::string environment;
    limits >> memory >> file >> open_files >> cpu_s >> cache >> cache_name;
    std::getline(limits >> std::ws, network);
    std::getline(limits >> std::ws, processes);
    std::getline(limits >> std::ws, environment);

    EXPECT_GT(memory, 0);
    EXPECT_LT(memory, sysconf(_SC_PHYS_PAGES) * sysconf(_SC_PAGESIZE));
    EXPECT_EQ(file, 123456789);
    EXPECT_EQ(open_files, 1024);
    EXPECT_GE(cpu_s, 600);
    EXPECT_EQ(cache, 12345);
    EXPECT_EQ(cache_name, "work-cache");
    const bool cut = worker.stderr_text().find("have network access") == std::string::npos &&
                     worker.stdout_text().find("have network access") == std::string::npos;
    EXPECT_EQ(network, cut ? "no network" : "network");
    EXPECT_EQ(processes, "no processes");
    EXPECT_EQ(environment, "no keys path");
}

}  // namespace
}  // namespace divemesh::runner
