#include <gtest/gtest.h>

#include <fstream>
#include <gmock/gmock.h>
#include <string>

#include "schemas/content_hash.hpp"
#include "storage/metric_store.hpp"
#include "storage/truth_store.hpp"
#include "tests/worker/runner/job_runner_fixture.hpp"

namespace divemesh::runner {
namespace {

using testing::HasSubstr;

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

}  // namespace
}  // namespace divemesh::runner
