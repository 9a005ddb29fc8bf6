// A real worker, parent and child, runs as processes; only the pipeline behind it is a fake.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <unistd.h>

#include "schemas/content_hash.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"
#include "storage/event_store.hpp"
#include "storage/job_store.hpp"
#include "storage/metric_store.hpp"
#include "storage/truth_store.hpp"
#include "storage/upload_store.hpp"
#include "storage/worker_store.hpp"
#include "tests/end_to_end/process.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::runner {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;
using testing::HasSubstr;

class JobRunnerTest : public testing::Test {
protected:
    Process start_worker(const std::string& deadline_ms = "600000",
                         const std::string& file_limit_bytes = "1000000000",
                         const std::string& scratch_bytes = "1000000000",
                         const std::string& min_free_bytes = "0") {
        const fs::path output = folder_ / ("worker-" + std::to_string(++num_workers_));
        fs::create_directories(output);
        return Process({FAKE_WORKER,
                        "worker",
                        catalog_url_,
                        (folder_ / "blobs").string(),
                        (folder_ / "work").string(),
                        "2000",
                        deadline_ms,
                        file_limit_bytes,
                        scratch_bytes,
                        min_free_bytes},
                       output);
    }

    // Makes a job for a dive whose reconstruction does what `script` says.
    Job make_job(const std::string& script, int max_attempts = 3) {
        std::ofstream(folder_ / "archive") << script;
        const Upload upload = uploads_.create({.project = "default", .length_bytes = 0});
        const std::string key = "dives/" + upload.id + "/archive";
        blobs_->put_file(key, folder_ / "archive");
        const Dive dive = dives_
                              .create({.upload_id = upload.id,
                                       .project = "default",
                                       .archive_sha256 = sha256_hex(script),
                                       .blob = key})
                              .dive;
        return jobs_
            .enqueue({.dive_id = dive.id, .preset = "standard", .max_attempts = max_attempts})
            .job;
    }

    bool reaches(const Job& job, JobState state) {
        return wait_until(seconds(60), [&] { return jobs_.get(job.id).state == state; });
    }
    pid_t child_of_marker() {
        EXPECT_TRUE(wait_until(seconds(60), [&] { return fs::exists(marker_); }));
        pid_t pid = 0;
        std::ifstream(marker_) >> pid;
        return pid;
    }
    static std::string state_of(pid_t pid) {
        std::string line;
        std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
        std::getline(stat, line);
        return line.empty() ? "" : line.substr(line.rfind(')') + 2, 1);
    }
    static bool is_gone(pid_t pid) {
        return wait_until(seconds(10), [&] {
            const std::string state = state_of(pid);
            return state.empty() || state == "Z";
        });
    }
    // Freezes the worker outside its own writes: in one, SQLite would make all other writers wait
    // until the worker continues.
    void freeze(Process& worker) {
        catalog_.transaction([&](soci::session&) {
            worker.send(SIGSTOP);
            EXPECT_TRUE(wait_until(seconds(10), [&] { return state_of(worker.pid()) == "T"; }));
        });
    }
    std::size_t num_blobs_of_jobs() const {
        std::size_t count = 0;
        if (!fs::exists(folder_ / "blobs/blobs/jobs")) return 0;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / "blobs/blobs/jobs"))
            count += entry.is_regular_file() && entry.path().filename() != "thumbnail.jpg";
        return count;
    }
    std::string wait_once() const { return "wait-once " + marker_.string(); }
    void let_go() const { std::ofstream(marker_.string() + ".go") << "go"; }

    TruthFile add_truth(const Job& of, const std::string& name, const std::string& content) {
        std::ofstream(folder_ / "truth") << content;
        const Upload upload = uploads_.create({.project = "default", .length_bytes = 0});
        const std::string key = "truth/" + upload.id + "/file";
        blobs_->put_file(key, folder_ / "truth");
        return storage::TruthStore(catalog_)
            .create({.upload_id = upload.id,
                     .project = "default",
                     .dive_id = of.dive_id,
                     .name = name,
                     .sha256 = sha256_hex(content),
                     .size_bytes = static_cast<std::int64_t>(content.size()),
                     .blob = key})
            .file;
    }
    std::string content_of(const Artifact& artifact) {
        const auto blob = blobs_->open(artifact.blob);
        std::string text(static_cast<std::size_t>(blob->size_bytes()), ' ');
        blob->read_at(0, text);
        return text;
    }

    TemporaryFolder folder_;
    fs::path marker_ = folder_ / "marker";
    std::string catalog_url_ = "sqlite://" + (folder_ / "catalog.db").string();
    storage::Catalog catalog_{catalog_url_};
    storage::UploadStore uploads_{catalog_};
    storage::DiveStore dives_{catalog_};
    storage::JobStore jobs_{catalog_};
    std::unique_ptr<storage::BlobStore> blobs_ =
        storage::open_blob_store((folder_ / "blobs").string());
    int num_workers_ = 0;
};

TEST_F(JobRunnerTest, AReportReadsItsReconstructionAndTruthAndItsMetricsAreKept) {
    const Job reconstruction = make_job("plain");
    const Process worker = start_worker();
    ASSERT_TRUE(reaches(reconstruction, JobState::Succeeded));
    add_truth(reconstruction, "../a b.tum", "poses");
    const Job report = jobs_
                           .enqueue({.dive_id = reconstruction.dive_id,
                                     .kind = JobKind::AccuracyReport,
                                     .options = {{"require", {"path_length_m>=3"}}}})
                           .job;
    ASSERT_TRUE(reaches(report, JobState::Succeeded)) << jobs_.get(report.id).failure.message;
    EXPECT_EQ(verdict_of(jobs_.get(report.id)), "failed");
    EXPECT_EQ(content_of(jobs_.artifact(report.id, "report.json")), "ply\n.._a_b.tum poses");
    const auto points =
        storage::MetricStore(catalog_).series({.metric = "trajectory.path_length_m"}, {}).items;
    ASSERT_EQ(points.size(), 2U);
    EXPECT_EQ(points[0].version, "fake 1");
    EXPECT_EQ(points[1].version, "fake 2");
    EXPECT_EQ(points[0].calibration_sha256, "fake calibration");
    EXPECT_EQ(points[1].rig, "fake rig");
}

TEST_F(JobRunnerTest, AComparisonReadsTwoReconstructions) {
    const Job before = make_job("plain before");
    const Job after = make_job("plain after");
    const auto compare = [&](double reach_m) {
        return jobs_
            .enqueue({.dive_id = before.dive_id,
                      .kind = JobKind::Compare,
                      .options = {{"with", after.dive_id}, {"reach_m", reach_m}}})
            .job;
    };
    const Job same_ground = compare(1.0);
    const Job other_ground = compare(11.0);
    const Process worker = start_worker();
    EXPECT_TRUE(reaches(same_ground, JobState::Succeeded));
    EXPECT_EQ(jobs_.artifacts(same_ground.id).size(), 1U);
    EXPECT_TRUE(reaches(other_ground, JobState::Failed)) << "trying again cannot help";
    EXPECT_EQ(jobs_.get(other_ground.id).failure.message, "other ground");
}

TEST_F(JobRunnerTest, TruthThatWasNamedAndCannotBeReadIsNotSaidToBeTheRecordingsFault) {
    const Job reconstruction = make_job("plain");
    const TruthFile truth = add_truth(reconstruction, "broken.tum", "");
    const Job report = jobs_
                           .enqueue({.dive_id = reconstruction.dive_id,
                                     .kind = JobKind::AccuracyReport,
                                     .options = {{"ground_truth", "broken.tum"}}})
                           .job;
    const Process worker = start_worker();
    ASSERT_TRUE(reaches(report, JobState::Failed));
    EXPECT_EQ(jobs_.get(report.id).failure.message, "the truth is empty");
    EXPECT_THAT(jobs_.get(report.id).failure.remedy, HasSubstr("correct that file"));
    EXPECT_EQ(storage::TruthStore(catalog_).get(truth.dive_id, truth.id).problem,
              "the truth is empty");
}

TEST_F(JobRunnerTest, AReportGoesOnWithTheNewestTruthThatCanBeReadAndSaysWhatItLeftAside) {
    const Job reconstruction = make_job("plain");
    const TruthFile good = add_truth(reconstruction, "good.tum", "poses");
    const TruthFile broken = add_truth(reconstruction, "broken.tum", "");
    const auto ask = [&] {
        return jobs_.enqueue({.dive_id = reconstruction.dive_id, .kind = JobKind::AccuracyReport})
            .job;
    };
    const Job first = ask();
    EXPECT_EQ(first.options["ground_truth"], broken.id);
    const Process worker = start_worker();
    for (const Job& report : {first, ask()}) {
        ASSERT_TRUE(reaches(report, JobState::Succeeded)) << jobs_.get(report.id).failure.message;
        EXPECT_EQ(jobs_.get(report.id).options["ground_truth"], good.id);
        const std::string text = content_of(jobs_.artifact(report.id, "report.json"));
        EXPECT_THAT(text, HasSubstr("poses"));
        EXPECT_THAT(text, HasSubstr(broken.id + ") is newer"));
        EXPECT_THAT(text, HasSubstr("the truth is empty"));
    }
}

TEST_F(JobRunnerTest, AReportWhoseTruthWasDeletedFailsAtOnceAndSaysSo) {
    const Job reconstruction = make_job("plain");
    const Upload upload = uploads_.create({.project = "default", .length_bytes = 0});
    storage::TruthStore truths(catalog_);
    const auto truth = truths.create({.upload_id = upload.id,
                                      .project = "default",
                                      .dive_id = reconstruction.dive_id,
                                      .sha256 = sha256_hex("poses"),
                                      .blob = "truth/" + upload.id + "/file"});
    const Job report =
        jobs_.enqueue({.dive_id = reconstruction.dive_id, .kind = JobKind::AccuracyReport}).job;
    truths.remove(reconstruction.dive_id, truth.file.id);
    const Process worker = start_worker();
    ASSERT_TRUE(reaches(report, JobState::Failed));
    const Job failed = jobs_.get(report.id);
    EXPECT_EQ(failed.failure.code, ErrorCode::Gone);
    EXPECT_EQ(failed.num_attempts, 1);
    EXPECT_THAT(failed.failure.message, HasSubstr("upload it again"));
}

// A14
TEST_F(JobRunnerTest, BeginsNothingOnADiskThatIsNearlyFull) {
    const Job job = make_job("ok");
    {
        Process worker = start_worker("600000", "1000000000", "1000000000", "4000000000000000000");
        ASSERT_TRUE(wait_until(seconds(10), [&] {
            return worker.stdout_text().find("disk_nearly_full") != std::string::npos;
        }));
        EXPECT_EQ(jobs_.get(job.id).state, JobState::Held);
        EXPECT_EQ(dives_.get(job.dive_id).state, DiveState::Checking);
    }
    Process worker = start_worker();
    EXPECT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();
}

// S19
TEST_F(JobRunnerTest, AnAttemptThatTalksWithoutEndHoldsUpNobody) {
    const Job job = make_job("talk");
    Process worker = start_worker();
    ASSERT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();

    EXPECT_EQ(jobs_.get(job.id).progress.stage, "evaluate") << "the last word is never lost";
    EXPECT_LT(storage::EventStore(catalog_).newest_sequence(), 200);
}

// The message of a failure contains names from the recording (A9, S29).
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

// Q5
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

// Q4
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

// Q8
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

// Q8
TEST_F(JobRunnerTest, AChildThatDoesNotListenIsKilled) {
    const Job job = make_job("deaf " + marker_.string());
    Process worker = start_worker();
    const pid_t child = child_of_marker();

    jobs_.cancel(job.id);

    EXPECT_TRUE(reaches(job, JobState::Cancelled));
    EXPECT_TRUE(is_gone(child));
}

// Q5
TEST_F(JobRunnerTest, AnAttemptPastItsDeadlineIsEnded) {
    const Job job = make_job("deaf " + marker_.string(), 1);
    Process worker = start_worker("500");

    EXPECT_TRUE(reaches(job, JobState::Dead));
    EXPECT_THAT(jobs_.get(job.id).failure.message, HasSubstr("deadline"));
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

TEST_F(JobRunnerTest, ADiskThatFillsWhileArtifactsAreWrittenLeavesNoneOfThem) {
    const Job job = make_job("large", 1);
    Process worker = start_worker("600000", "33554432");

    ASSERT_TRUE(reaches(job, JobState::Dead)) << worker.stderr_text();
    EXPECT_EQ(jobs_.get(job.id).failure.code, ErrorCode::OutOfSpace);
    EXPECT_TRUE(jobs_.artifacts(job.id).empty());
    EXPECT_EQ(num_blobs_of_jobs(), 0u);
}

// S19
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

// Q13, S19
TEST_F(JobRunnerTest, AnAttemptThatTakesMoreScratchThanItMayIsEnded) {
    const Job job = make_job("fill", 1);
    Process worker = start_worker("600000", "1000000000", "4194304");

    ASSERT_TRUE(reaches(job, JobState::Dead)) << worker.stderr_text();
    EXPECT_EQ(jobs_.get(job.id).failure.code, ErrorCode::OutOfSpace);
}

// Q13, S19
TEST_F(JobRunnerTest, AnAttemptHasLimitsAndNoNetworkAndStartsNothing) {
    const Job job = make_job("limits");
    Process worker = start_worker("600000", "1000000000", "123456789");
    ASSERT_TRUE(reaches(job, JobState::Succeeded)) << worker.stderr_text();

    std::istringstream limits(
        read_text(blobs_->local_copy(jobs_.artifact(job.id, "limits.txt").blob, folder_.path())));
    std::int64_t memory = 0, file = 0, open_files = 0, cpu_s = 0, cache = 0;
    std::string cache_name;
    std::string network;
    std::string processes;
    limits >> memory >> file >> open_files >> cpu_s >> cache >> cache_name;
    std::getline(limits >> std::ws, network);
    std::getline(limits >> std::ws, processes);

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

// Q11
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

// Q14
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
