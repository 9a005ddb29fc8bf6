#include "storage/report_jobs.hpp"

#include <gtest/gtest.h>

#include "storage/dive_removal.hpp"
#include "storage/truth_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using nlohmann::json;

class ReportJobsTest : public StoreTest {
protected:
    Job ask(JobKind kind, const Dive& dive, const json& options = json::object()) {
        return jobs_
            .enqueue({.dive_id = dive.id, .kind = kind, .preset = "fast", .options = options})
            .job;
    }
    Job report(const Dive& dive, const json& options = json::object()) {
        return ask(JobKind::AccuracyReport, dive, options);
    }
    Job compare(const Dive& dive, const std::string& with) {
        return ask(JobKind::Compare, dive, {{"with", with}});
    }
    Job succeed(const Measurement& measured = {}) {
        const Claim done = claim();
        EXPECT_TRUE(jobs_.succeed(done.lease, {}, measured));
        return jobs_.get(done.job.id);
    }
    Job reconstructed(const Dive& dive) {
        enqueue(dive);
        return succeed();
    }
    TruthFile add_truth(const Dive& dive, TruthKind kind, const std::string& name) {
        const Upload upload = finished_upload(dive.project);
        return TruthStore(catalog_)
            .create({.upload_id = upload.id,
                     .project = dive.project,
                     .dive_id = dive.id,
                     .kind = kind,
                     .name = name,
                     .sha256 = sha256_hex(name),
                     .size_bytes = 10,
                     .blob = "truth/" + upload.id + "/file"})
            .file;
    }
    void remove(const Dive& dive) {
        DiveRemoval(catalog_).remove(dive.id, kOver, [](const Dive&) {});
    }
};

TEST_F(ReportJobsTest, AReportIsOfTheNewestReconstructionThatHasSucceeded) {
    const Dive dive = ready_dive();
    reconstructed(dive);
    const Job newest = reconstructed(dive);
    enqueue(dive);
    const Job job = report(dive);
    EXPECT_EQ(job.options["job"], newest.id);
    EXPECT_EQ(job.parents, std::vector{newest.id});
    EXPECT_EQ(job.preset, "standard") << "the reconstruction's";
    EXPECT_EQ(job.state, JobState::Queued);
    EXPECT_EQ(report(dive).id, job.id) << "the same work is queued once";
}

TEST_F(ReportJobsTest, WithoutOneItsDiveIsReconstructedFirst) {
    const Dive dive = ready_dive();
    const Job job = report(dive);
    EXPECT_EQ(job.state, JobState::Held);
    const Job made = jobs_.get(job.options["job"]);
    EXPECT_EQ(made.kind, JobKind::Reconstruct);
    EXPECT_EQ(made.preset, "fast");
    EXPECT_EQ(report(dive).id, job.id) << "asked again, the one under way serves";
    EXPECT_EQ(succeed().id, made.id);
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Queued);
}

TEST_F(ReportJobsTest, AFreshReportIsOfAReconstructionByThisVersion) {
    const Dive dive = ready_dive();
    enqueue(dive);
    const Job old = succeed({.metrics = {{"x", 1.0, "1", ""}}, .version = "1"});
    const NewJob wanted{.dive_id = dive.id,
                        .kind = JobKind::AccuracyReport,
                        .preset = "standard",
                        .fresh_version = "2"};
    const Job job = jobs_.enqueue(wanted).job;
    EXPECT_NE(job.options["job"], old.id);
    const Job again = succeed({.metrics = {{"x", 1.0, "1", ""}}, .version = "2"});
    EXPECT_EQ(job.options["job"], again.id);
    EXPECT_EQ(jobs_.enqueue(wanted).job.id, job.id);
}

TEST_F(ReportJobsTest, TruthIsTheNewestOfItsKindUnlessItIsNamed) {
    const Dive dive = ready_dive();
    reconstructed(dive);
    EXPECT_FALSE(report(dive).options.contains("ground_truth"));
    const TruthFile first = add_truth(dive, TruthKind::GroundTruth, "first.tum");
    const TruthFile second = add_truth(dive, TruthKind::GroundTruth, "second.tum");
    const TruthFile mesh = add_truth(dive, TruthKind::Reference, "mesh.ply");
    const json newest = report(dive).options;
    EXPECT_EQ(newest["ground_truth"], second.id);
    EXPECT_EQ(newest["newest"], nlohmann::json({"ground_truth", "reference"}));
    EXPECT_EQ(newest["reference"], mesh.id);
    for (const std::string& name : {first.id, first.name})
        EXPECT_EQ(report(dive, {{"ground_truth", name}}).options["ground_truth"], first.id);
    const Job own = report(dive, {{"ground_truth", "dive"}});
    EXPECT_EQ(own.options["ground_truth"], "dive");
    EXPECT_EQ(jobs_.inputs(own).truth.size(), 1U) << "the mesh alone";
    for (const char* name : {"third.tum", "mesh.ply", "../second.tum"})
        EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] {
            report(dive, {{"ground_truth", name}});
        })) << name;
}

TEST_F(ReportJobsTest, TruthThatIsUnreadableIsMarkedAndLeftAside) {
    const Dive dive = ready_dive();
    reconstructed(dive);
    const TruthFile good = add_truth(dive, TruthKind::GroundTruth, "good.tum");
    const TruthFile broken = add_truth(dive, TruthKind::GroundTruth, "broken.tum");
    const Failure failure{ErrorCode::BadData, "line 3"};
    const UnreadableTruth unreadable{TruthKind::GroundTruth, "line 3"};
    const Job newest = report(dive);
    EXPECT_TRUE(jobs_.fail(claim().lease, failure, unreadable));
    EXPECT_EQ(TruthStore(catalog_).get(dive.id, broken.id).problem, "line 3");
    EXPECT_EQ(event_types(dive.id).back(), "dive.truth_unreadable");
    EXPECT_EQ(jobs_.get(newest.id).state, JobState::Queued);
    EXPECT_EQ(jobs_.get(newest.id).num_attempts, 0);
    EXPECT_EQ(jobs_.get(newest.id).options["ground_truth"], good.id);
    ASSERT_EQ(jobs_.inputs(jobs_.get(newest.id)).set_aside.size(), 1U);
    succeed();
    EXPECT_EQ(report(dive).options["ground_truth"], good.id);
    succeed();

    const Job named = report(dive, {{"ground_truth", broken.id}});
    EXPECT_TRUE(jobs_.inputs(named).set_aside.empty());
    jobs_.fail(claim().lease, failure, unreadable);
    EXPECT_EQ(jobs_.get(named.id).state, JobState::Failed);
    add_truth(dive, TruthKind::GroundTruth, "broken.tum");
    EXPECT_EQ(report(dive).options["ground_truth"], broken.id) << "sent again, it is tried again";
}

TEST_F(ReportJobsTest, WhereNoTruthIsReadableTheRecordingsOwnServes) {
    const Dive dive = ready_dive();
    reconstructed(dive);
    add_truth(dive, TruthKind::Areas, "areas.json");
    const Job job = report(dive);
    jobs_.fail(
        claim().lease, {ErrorCode::BadData, "why"}, UnreadableTruth{TruthKind::Areas, "why"});
    EXPECT_FALSE(jobs_.get(job.id).options.contains("areas"));
    EXPECT_EQ(jobs_.inputs(jobs_.get(job.id)).set_aside.size(), 1U);
}

TEST_F(ReportJobsTest, AComparisonReadsTheOutlinesThatItNamesAndNoOthers) {
    const Dive before = ready_dive("before");
    const Dive after = ready_dive("after");
    reconstructed(before);
    reconstructed(after);
    const TruthFile areas = add_truth(before, TruthKind::Areas, "areas.json");
    add_truth(after, TruthKind::Areas, "later.json");
    EXPECT_FALSE(compare(before, after.id).options.contains("areas"));
    const Job job = ask(JobKind::Compare, before, {{"with", after.id}, {"areas", "areas.json"}});
    EXPECT_EQ(job.options["areas"], areas.id);
    ASSERT_EQ(jobs_.inputs(job).truth.size(), 1U);
    EXPECT_EQ(jobs_.inputs(job).truth.at("areas").id, areas.id);
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] {
        ask(JobKind::Compare, before, {{"with", after.id}, {"areas", "later.json"}});
    }));
}

TEST_F(ReportJobsTest, AComparisonReadsOutlinesOfEachOfItsDives) {
    const Dive before = ready_dive("before");
    const Dive after = ready_dive("after");
    reconstructed(before);
    reconstructed(after);
    const TruthFile areas = add_truth(before, TruthKind::Areas, "areas.json");
    const TruthFile later = add_truth(after, TruthKind::Areas, "later.json");
    const auto compare_by = [&](const std::string& first, const std::string& second) {
        return ask(JobKind::Compare,
                   before,
                   {{"with", after.id}, {"areas", first}, {"later_areas", second}});
    };
    const Job job = compare_by("areas.json", "later.json");
    EXPECT_EQ(job.options["later_areas"], later.id);
    ASSERT_EQ(jobs_.inputs(job).truth.size(), 2U);
    EXPECT_EQ(jobs_.inputs(job).truth.at("areas").id, areas.id);
    EXPECT_EQ(jobs_.inputs(job).truth.at("later_areas").id, later.id);
    EXPECT_EQ(compare_by(areas.id, later.id).id, job.id) << "the same work is queued once";
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { compare_by("areas.json", "areas.json"); }));
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { compare_by("", "later.json"); }));
    EXPECT_EQ(compare_by("", "").id, compare(before, after.id).id) << "without outlines";
}

TEST_F(ReportJobsTest, AComparisonIsOfTwoReconstructions) {
    const Dive before = ready_dive("before");
    const Dive after = ready_dive("after");
    const Job a = reconstructed(before);
    const Job b = reconstructed(after);
    const Job job = compare(before, after.id);
    EXPECT_EQ(job.options["job"], a.id);
    EXPECT_EQ(job.options["with"], b.id);
    EXPECT_EQ(job.state, JobState::Queued);
    EXPECT_EQ(compare(before, b.id).id, job.id);
    EXPECT_EQ(jobs_.inputs(job).reconstructions.size(), 2U);
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { compare(before, before.id); }));
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { compare(before, job.id); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { compare(before, "dive_none"); }));
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { report(before, {{"job", b.id}}); }));
}

TEST_F(ReportJobsTest, NothingOfAnotherProjectIsFound) {
    const Dive mine = ready_dive("mine");
    reconstructed(mine);
    const Dive theirs = create_dive("theirs").dive;
    catalog_.transaction([&](soci::session& session) {
        session << "UPDATE dives SET project = 'theirs' WHERE id = :id", soci::use(theirs.id);
        session << "UPDATE jobs SET project = 'theirs' WHERE dive_id = :id", soci::use(theirs.id);
    });
    finish_intake(theirs);
    const Job job = reconstructed(dives_.get(theirs.id));
    for (const std::string& with : {theirs.id, job.id})
        EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { compare(mine, with); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { report(mine, {{"job", job.id}}); }));
}

TEST_F(ReportJobsTest, WhatWasDeletedSinceIsSaidWithWhatToDo) {
    const Dive before = ready_dive("before");
    const Dive after = ready_dive("after");
    reconstructed(before);
    reconstructed(after);
    const Job job = compare(before, after.id);
    remove(after);
    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { jobs_.inputs(job); }));
    EXPECT_TRUE(DiveRemoval(catalog_).forget(after.id));
    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { jobs_.inputs(job); }));

    const TruthFile truth = add_truth(before, TruthKind::GroundTruth, "poses.tum");
    const Job of_truth = report(before);
    TruthStore(catalog_).remove(before.id, truth.id);
    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { jobs_.inputs(of_truth); }));
}

TEST_F(ReportJobsTest, ADiveThatARunningComparisonReadsIsNotRemovedUnderIt) {
    const Dive before = ready_dive("before");
    const Dive after = ready_dive("after");
    reconstructed(before);
    reconstructed(after);
    compare(before, after.id);
    const Claim running = claim();
    remove(after);
    EXPECT_TRUE(DiveRemoval(catalog_).expired(10).empty());
    jobs_.succeed(running.lease, {});
    EXPECT_EQ(DiveRemoval(catalog_).expired(10).size(), 1U);
}

TEST_F(ReportJobsTest, ATagHasToBeOfTheDive) {
    const Dive dive = create_dive("tagged").dive;
    finish_intake(dive, {.tags = {"yearly"}});
    EXPECT_EQ(report(dive, {{"tag", "yearly"}}).options["tag"], "yearly");
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] {
        report(dive, {{"tag", "monthly"}});
    }));
}

}  // namespace
}  // namespace divemesh::storage
