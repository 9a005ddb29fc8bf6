// Workers whose own storage fails: no job has a part in it.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <gmock/gmock.h>
#include <string>
#include <thread>

#include "storage/data_id.hpp"
#include "storage/worker_store.hpp"
#include "tests/small_disk.hpp"
#include "tests/worker/runner/job_runner_fixture.hpp"

namespace divemesh::runner {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;
using testing::HasSubstr;

class WorkerStorageTest : public JobRunnerTest {
protected:
    bool is_told(const std::string& reason) {
        return wait_until(seconds(20), [&] {
            const auto workers = storage::WorkerStore(catalog_).list();
            return !workers.empty() && workers.front().waits_for == reason;
        });
    }
    fs::path blobs_folder_ = folder_ / "blobs";
    fs::path away_ = folder_ / "away";
};

TEST_F(WorkerStorageTest, AWorkerWithoutTheBlobsOfItsCatalogDoesNotStart) {
    storage::claim_data(catalog_, *blobs_);
    const Job job = make_job("ok");
    fs::rename(blobs_folder_, away_);
    for (const bool mount_point : {false, true}) {
        if (mount_point) fs::create_directories(blobs_folder_);
        Process worker = start_worker();
        EXPECT_NE(worker.wait(seconds(20)).value_or(0), 0);
        EXPECT_FALSE(fs::exists(blobs_folder_ / "blobs")) << "a store was made";
    }
    storage::open_blob_store(blobs_folder_.string());  // another store, without an id
    Process worker = start_worker();
    EXPECT_NE(worker.wait(seconds(20)).value_or(0), 0);
    EXPECT_TRUE(jobs_.attempts(job.id).empty());
}

TEST_F(WorkerStorageTest, AWorkerWithoutACatalogSaysWhereItLookedAndMakesNone) {
    catalog_url_ = "sqlite://" + (folder_ / "elsewhere" / "catalog.db").string();
    Process worker = start_worker();

    EXPECT_NE(worker.wait(seconds(20)).value_or(0), 0);
    EXPECT_THAT(worker.stderr_text(), HasSubstr((folder_ / "elsewhere/catalog.db").string()));
    EXPECT_FALSE(fs::exists(folder_ / "elsewhere"));
}

TEST_F(WorkerStorageTest, AWorkerThatLosesItsBlobsTakesNoJobUntilTheyAreBack) {
    storage::claim_data(catalog_, *blobs_);
    Process worker = start_worker();
    ASSERT_TRUE(reaches(make_job("ok"), JobState::Succeeded)) << worker.stderr_text();
    fs::rename(blobs_folder_, away_);
    ASSERT_TRUE(is_told("storage"));
    const Job job = make_job("ok later");

    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    EXPECT_TRUE(jobs_.attempts(job.id).empty());
    EXPECT_EQ(dives_.get(job.dive_id).state, DiveState::Checking);
    fs::rename(away_, blobs_folder_);
    EXPECT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();
    EXPECT_TRUE(is_told(""));
}

// Data of an earlier version get their id while a worker is running.
TEST_F(WorkerStorageTest, AWorkerGoesOnWhenItsDataGetTheirId) {
    Process worker = start_worker();
    ASSERT_TRUE(reaches(make_job("ok"), JobState::Succeeded)) << worker.stderr_text();

    storage::claim_data(catalog_, *blobs_);

    EXPECT_TRUE(reaches(make_job("ok later"), JobState::Succeeded)) << worker.stderr_text();
}

TEST_F(WorkerStorageTest, AnAttemptThatLosesItsBlobsDoesNotCount) {
    storage::claim_data(catalog_, *blobs_);
    const Job job = make_job(wait_once(), 1);
    Process worker = start_worker();
    const pid_t child = child_of_marker();
    fs::rename(blobs_folder_, away_);
    ::kill(child, SIGBUS);  // as a read from a disk that is gone

    ASSERT_TRUE(fails_without_counting(job)) << worker.stderr_text();
    EXPECT_THAT(jobs_.get(job.id).failure.message, HasSubstr("lost its blob store"));
    fs::rename(away_, blobs_folder_);
    EXPECT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();
}

TEST_F(WorkerStorageTest, AMissingBlobInTheRightStoreCounts) {
    storage::claim_data(catalog_, *blobs_);
    Process worker = start_worker();
    const Job first = make_job("ok");
    ASSERT_TRUE(reaches(first, JobState::Succeeded)) << worker.stderr_text();
    const Job job =
        jobs_.enqueue({.dive_id = first.dive_id, .preset = "fast", .max_attempts = 1}).job;
    fs::remove_all(blobs_folder_ / "blobs" / "dives");

    EXPECT_TRUE(reaches(job, JobState::Dead)) << worker.stderr_text();
}

TEST_F(WorkerStorageTest, AnAttemptOnADiskThatFillsUpDoesNotCount) {
    const SmallDisk disk(100);
    if (!disk.mounted()) GTEST_SKIP() << "needs the right to mount a tmpfs";
    work_folder_ = disk.path() / "work";
    const Job job = make_job(wait_once(), 1);
    Process worker = start_worker("600000", "1000000000", "1000000000", "1048576");
    const pid_t child = child_of_marker();
    disk.fill();
    ::kill(child, SIGBUS);  // as a write to a mapped file without a block

    ASSERT_TRUE(fails_without_counting(job)) << worker.stderr_text();
    EXPECT_EQ(jobs_.get(job.id).failure.code, ErrorCode::OutOfSpace);
    EXPECT_TRUE(is_told("disk"));
    fs::remove(disk.path() / "filler");
    EXPECT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();
}

}  // namespace
}  // namespace divemesh::runner
