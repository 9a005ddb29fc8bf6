#include "storage/result_removal.hpp"

#include <gmock/gmock.h>

#include "storage/project_usage.hpp"
#include "storage/queue_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::chrono::milliseconds kDay = std::chrono::hours(24);

class ResultRemovalTest : public StoreTest {
protected:
    // Makes a reconstruction with two artifacts of 300 and 700 bytes.
    Job result_of(const Dive& dive) {
        const Job job = enqueue(dive);
        const Lease lease = claim().lease;
        jobs_.succeed(lease,
                      {{job.id, "mesh.ply", "", "", 300, "jobs/" + job.id + "/1/mesh.ply"},
                       {job.id, "cloud.ply", "", "", 700, "jobs/" + job.id + "/1/cloud.ply"}});
        return jobs_.get(job.id);
    }
    std::int64_t stored_bytes() { return read_usage(catalog_, "").stored_bytes; }
    std::vector<std::string> listed(bool deleted) {
        std::vector<std::string> ids;
        for (const Job& job :
             jobs_.list({.kind = JobKind::Reconstruct, .deleted = deleted}, {}).items)
            ids.push_back(job.id);
        return ids;
    }
    void finished_at(const Job& job, std::int64_t time_ms) {
        catalog_.transaction([&](soci::session& session) {
            session << "UPDATE jobs SET finished_at_ms = :time WHERE id = :id",
                soci::use(time_ms, "time"), soci::use(job.id, "id");
        });
    }

    int remove_old(int limit = 100) {
        return removal_.remove_old(
            kDay, limit, [&](soci::session&, const std::string& id) { told_.push_back(id); });
    }

    ResultRemoval removal_{catalog_};
    std::vector<std::string> told_;
};

TEST_F(ResultRemovalTest, ResultsCountTowardsTheQuotaUntilTheyAreRemoved) {
    const Dive dive = ready_dive();
    const std::int64_t without = stored_bytes();
    const Job job = result_of(dive);
    EXPECT_EQ(stored_bytes(), without + 1000);
    removal_.remove(job.id, std::chrono::milliseconds(0));
    EXPECT_EQ(stored_bytes(), without + 1000);

    EXPECT_THAT(removal_.expired(10), ElementsAre(job.id));
    removal_.forget(job.id);
    EXPECT_EQ(stored_bytes(), without);
    EXPECT_THAT(removal_.expired(10), IsEmpty());
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Succeeded);
}

TEST_F(ResultRemovalTest, ADeletedResultIsGoneUntilItIsRestored) {
    const Job job = result_of(ready_dive());
    removal_.remove(job.id, kDay);

    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { jobs_.artifacts(job.id); }));
    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { jobs_.artifact(job.id, "mesh.ply"); }));
    EXPECT_THAT(listed(false), IsEmpty());
    EXPECT_THAT(listed(true), ElementsAre(job.id));
    EXPECT_THAT(removal_.expired(10), IsEmpty());
    const Deletion deletion = removal_.deletion_of(job.id);
    EXPECT_EQ(deletion.expires_at_ms - deletion.deleted_at_ms, kDay.count());
    removal_.remove(job.id, 2 * kDay);  // expires as planned
    EXPECT_EQ(removal_.deletion_of(job.id).expires_at_ms, deletion.expires_at_ms);
    removal_.restore(job.id);
    EXPECT_EQ(jobs_.artifacts(job.id).size(), 2U);
    EXPECT_THAT(listed(false), ElementsAre(job.id));
    EXPECT_EQ(removal_.deletion_of(job.id).deleted_at_ms, 0);

    removal_.remove(job.id, std::chrono::milliseconds(0));
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { removal_.restore(job.id); }));
    EXPECT_THAT(event_types(job.id),
                testing::IsSupersetOf({"job.deleted", "job.restored", "job.deleted"}));
}

TEST_F(ResultRemovalTest, DeletesOnlyWhatIsFinishedAndNotRead) {
    const Dive dive = ready_dive();
    const std::string intake = jobs_.list({.kind = JobKind::Intake}, {}).items.front().id;
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { removal_.remove(intake, kDay); }));
    const Job waiting = enqueue(dive);
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { removal_.remove(waiting.id, kDay); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { removal_.remove("job_none", kDay); }));
    jobs_.cancel(waiting.id);
    const Job read = result_of(dive);
    const Job reader =
        jobs_.enqueue({.dive_id = dive.id, .preset = "fast", .parents = {read.id}}).job;
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { removal_.remove(read.id, kDay); }));
    jobs_.cancel(reader.id);
    removal_.remove(read.id, kDay);
}

TEST_F(ResultRemovalTest, AReportMakesAnewWhatWasDeleted) {
    const Dive dive = ready_dive();
    const Job job = result_of(dive);
    const NewJob report{.dive_id = dive.id, .kind = JobKind::AccuracyReport, .preset = "standard"};
    removal_.remove(job.id, kDay);

    const Job made = jobs_.enqueue(report).job;
    EXPECT_NE(made.options["job"], job.id);
    EXPECT_EQ(made.state, JobState::Held);
}

TEST_F(ResultRemovalTest, AReportOrComparisonOfADeletedResultIsRefusedAtOnce) {
    const Dive dive = ready_dive();
    const Job deleted = result_of(dive);
    const Job kept = result_of(dive);
    const NewJob report{.dive_id = dive.id,
                        .kind = JobKind::AccuracyReport,
                        .preset = "standard",
                        .options = {{"job", deleted.id}}};
    const NewJob comparison{.dive_id = dive.id,
                            .kind = JobKind::Compare,
                            .preset = "standard",
                            .options = {{"job", kept.id}, {"with", deleted.id}}};
    removal_.remove(deleted.id, kDay);

    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { jobs_.enqueue(report); }));
    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { jobs_.enqueue(comparison); }));
    removal_.restore(deleted.id);
    EXPECT_EQ(jobs_.enqueue(report).job.options["job"], deleted.id);
    EXPECT_EQ(jobs_.enqueue(comparison).job.options["with"], deleted.id);
}

TEST_F(ResultRemovalTest, KeepsTheNewestResultsOfADive) {
    QueueStore queues(catalog_);
    const Dive wreck = ready_dive("wreck");
    std::vector<Job> results;
    for (int i = 0; i < 4; ++i) {
        results.push_back(result_of(wreck));
        finished_at(results.back(), 1000 + i);
    }
    const Job other = result_of(ready_dive("reef"));
    EXPECT_EQ(remove_old(), 0);
    queues.change("", {.keep_results = 3});
    queues.change("default", {.keep_results = 2});  // counts more than that of all projects

    EXPECT_EQ(remove_old(), 2);
    EXPECT_THAT(listed(true), testing::UnorderedElementsAre(results[0].id, results[1].id));
    EXPECT_THAT(listed(false),
                testing::UnorderedElementsAre(results[2].id, results[3].id, other.id));
    EXPECT_EQ(remove_old(), 0);
    EXPECT_THAT(told_, testing::UnorderedElementsAre(results[0].id, results[1].id));
    EXPECT_EQ(queues.get("default").keep_results, 2);
    EXPECT_TRUE(
        throws_code(ErrorCode::InvalidArgument, [&] { queues.change("", {.keep_results = -1}); }));
}

TEST_F(ResultRemovalTest, WhatWasRestoredIsNotDeletedByTheRule) {
    const Dive dive = ready_dive();
    std::vector<Job> results;
    for (int i = 0; i < 4; ++i) {
        results.push_back(result_of(dive));
        finished_at(results.back(), 1000 + i);
    }
    QueueStore(catalog_).change("default", {.keep_results = 1});
    EXPECT_EQ(remove_old(2), 2);  // a round
    EXPECT_EQ(remove_old(2), 1);
    removal_.restore(results[0].id);

    EXPECT_EQ(remove_old(), 0);
    EXPECT_THAT(listed(false), testing::UnorderedElementsAre(results[0].id, results[3].id));
}

TEST_F(ResultRemovalTest, RemovesNothingOfAJobThatWasTriedAgain) {
    const Job job = result_of(ready_dive());
    removal_.remove(job.id, std::chrono::milliseconds(0));
    EXPECT_THAT(removal_.blob_prefixes(job.id), ElementsAre("jobs/" + job.id + "/1/"));
    catalog_.transaction([&](soci::session& session) {
        session << "UPDATE jobs SET deleted_at_ms = 0 WHERE id = :id", soci::use(job.id, "id");
    });
    removal_.forget(job.id);
    EXPECT_EQ(jobs_.artifacts(job.id).size(), 2U);
}

}  // namespace
}  // namespace divemesh::storage
