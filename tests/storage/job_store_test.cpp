#include "storage/job_store.hpp"

#include <gmock/gmock.h>

#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using testing::ElementsAre;
using JobStoreTest = StoreTest;

TEST_F(JobStoreTest, QueuesAJobOnAReadyDive) {
    const Dive dive = ready_dive();

    const Job job = jobs_
                        .enqueue({.dive_id = dive.id,
                                  .preset = "paper",
                                  .options = {{"voxel_m", 0.02}},
                                  .priority = 7})
                        .job;

    EXPECT_EQ(job.state, JobState::Queued);
    const Job stored = jobs_.get(job.id);
    EXPECT_EQ(stored.project, "default");
    EXPECT_EQ(stored.preset, "paper");
    EXPECT_EQ(stored.options, nlohmann::json({{"voxel_m", 0.02}}));
    EXPECT_EQ(stored.priority, 7);
    EXPECT_GT(stored.created_at_ms, 0);
}

TEST_F(JobStoreTest, AReconstructionKeepsItsFindingsAndItsVerdictAndTellsThem) {
    const Job job = enqueue(ready_dive());
    Measurement measured;
    measured.verdict = Verdict::UsableWithRestrictions;
    measured.findings = {{Severity::Warning, "tracking_lost", "frames 3 to 9", "lost", "slower"}};

    ASSERT_TRUE(jobs_.succeed(claim().lease, {}, measured));

    const Job stored = jobs_.get(job.id);
    EXPECT_EQ(verdict_of(stored), "usable_with_restrictions");
    ASSERT_EQ(stored.findings.size(), 1U);
    EXPECT_EQ(stored.findings[0].where, "frames 3 to 9");
    const auto told = events_.since(0, "", 1000);
    ASSERT_FALSE(told.empty());
    EXPECT_EQ(told.back().data.at("verdict"), "usable_with_restrictions");
    EXPECT_EQ(told.back().data.at("findings").size(), 1U);
}

TEST_F(JobStoreTest, HoldsAJobUntilTheIntakeOfItsDiveHasSucceeded) {
    const Dive dive = create_dive("wreck").dive;
    const Job job = enqueue(dive);
    EXPECT_EQ(job.state, JobState::Held);

    finish_intake(dive);

    EXPECT_EQ(jobs_.get(job.id).state, JobState::Queued);
}

TEST_F(JobStoreTest, FailsHeldJobsOfARefusedDiveWithTheReason) {
    const CreatedDive created = create_dive("wreck", "standard");
    IntakeResult refusal;
    refusal.findings.push_back(
        {.severity = Severity::Error, .where = "mav0/cam1", .message = "there is no right camera"});

    finish_intake(created.dive, refusal);

    const Job job = jobs_.get(created.job_id);
    EXPECT_EQ(job.state, JobState::Failed);
    EXPECT_EQ(job.failure.code, ErrorCode::BadData);
    EXPECT_THAT(job.failure.message, testing::HasSubstr("there is no right camera"));
}

TEST_F(JobStoreTest, FailsHeldJobsWhenTheIntakeTheyWaitForIsGivenUp) {
    const CreatedDive created = create_dive("wreck", "standard");
    const Claim intake = claim();

    for (int i = 0; i < 3; ++i) {
        const Lease lease = i == 0 ? intake.lease : claim().lease;
        EXPECT_TRUE(jobs_.fail(lease, {ErrorCode::Unavailable, "crashed"}));
    }

    EXPECT_EQ(jobs_.get(intake.job.id).state, JobState::Dead);
    EXPECT_EQ(jobs_.get(created.job_id).state, JobState::Failed);
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { jobs_.retry(created.job_id); }));
    jobs_.retry(intake.job.id);
    EXPECT_EQ(jobs_.get(created.job_id).state, JobState::Held);
    finish_intake(created.dive);
    EXPECT_EQ(jobs_.get(created.job_id).state, JobState::Queued);
}

// The server may die after the job and before the answer is kept: a repeated request makes no
// second job, even when the first one has long ended.
TEST_F(JobStoreTest, ARequestThatComesAgainFindsItsJobWhateverBecameOfIt) {
    const Dive dive = ready_dive();
    const NewJob request{.dive_id = dive.id, .request_key = "first"};
    const Job job = jobs_.enqueue(request).job;
    jobs_.cancel(job.id);

    const EnqueuedJob again = jobs_.enqueue(request);
    const EnqueuedJob other = jobs_.enqueue({.dive_id = dive.id, .request_key = "second"});
    const EnqueuedJob twin = jobs_.enqueue({.dive_id = dive.id, .request_key = "third"});
    jobs_.cancel(other.job.id);
    const EnqueuedJob twin_again = jobs_.enqueue({.dive_id = dive.id, .request_key = "third"});

    EXPECT_FALSE(again.is_new);
    EXPECT_EQ(again.job.id, job.id);
    EXPECT_EQ(again.job.state, JobState::Cancelled);
    EXPECT_TRUE(other.is_new);
    EXPECT_EQ(twin.job.id, other.job.id);
    EXPECT_EQ(twin_again.job.id, other.job.id);
}

TEST_F(JobStoreTest, RefusesAJobOnARefusedDive) {
    const Dive dive = create_dive("wreck").dive;
    finish_intake(dive, {.findings = {{.severity = Severity::Error, .message = "empty"}}});

    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { enqueue(dive); }));
}

TEST_F(JobStoreTest, RefusesWhatItCannotKeep) {
    const Dive dive = ready_dive();

    for (const NewJob& wrong : {NewJob{.dive_id = dive.id, .kind = JobKind::Intake},
                                NewJob{.dive_id = dive.id, .priority = 1000},
                                NewJob{.dive_id = dive.id, .max_attempts = 0},
                                NewJob{.dive_id = dive.id, .options = "text"}})
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { jobs_.enqueue(wrong); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { jobs_.enqueue({.dive_id = "dive_x"}); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { jobs_.get("job_x"); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { jobs_.cancel("' OR 1=1 --"); }));
}

TEST_F(JobStoreTest, CancelsAQueuedJobAtOnce) {
    const Job job = enqueue(ready_dive());

    EXPECT_EQ(jobs_.cancel(job.id).state, JobState::Cancelled);
    EXPECT_FALSE(jobs_.claim("worker", kLong));
}

TEST_F(JobStoreTest, CancelsAHeldJobAtOnce) {
    const Job job = enqueue(create_dive("wreck").dive);

    EXPECT_EQ(jobs_.cancel(job.id).state, JobState::Cancelled);
}

TEST_F(JobStoreTest, CancelOfARunningJobReachesItsWorkerWithTheNextRenewal) {
    const Job job = enqueue(ready_dive());
    const Lease lease = claim().lease;
    EXPECT_FALSE(jobs_.renew(lease, kLong).cancel_requested);

    EXPECT_EQ(jobs_.cancel(job.id).state, JobState::Running);

    EXPECT_TRUE(jobs_.renew(lease, kLong).cancel_requested);
    EXPECT_TRUE(jobs_.fail(lease, {ErrorCode::Cancelled, "cancelled"}));
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Cancelled);
    EXPECT_EQ(jobs_.attempts(job.id).at(0).state, AttemptState::Cancelled);
}

TEST_F(JobStoreTest, ACancelledJobIsNotTriedAgainWhenItsWorkerIsLost) {
    const Job job = enqueue(ready_dive());
    claim(kOver);
    jobs_.cancel(job.id);

    jobs_.requeue_expired();

    EXPECT_EQ(jobs_.get(job.id).state, JobState::Cancelled);
}

TEST_F(JobStoreTest, RefusesToCancelWhatIsFinished) {
    const Job job = enqueue(ready_dive());
    jobs_.succeed(claim().lease, {});

    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { jobs_.cancel(job.id); }));
}

TEST_F(JobStoreTest, RetriesWhatFailedOrWasCancelledOrGivenUp) {
    const Dive dive = ready_dive();
    const Job failed = enqueue(dive, 1);
    jobs_.fail(claim().lease, {ErrorCode::BadData, "no frames"});
    const Job dead = enqueue(dive, 1);
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "crashed"});
    const Job cancelled = enqueue(dive, 1);
    jobs_.cancel(cancelled.id);
    EXPECT_EQ(jobs_.get(failed.id).state, JobState::Failed);
    EXPECT_EQ(jobs_.get(dead.id).state, JobState::Dead);

    for (const Job& job : {failed, dead, cancelled}) {
        const Job again = jobs_.retry(job.id);
        EXPECT_EQ(again.state, JobState::Queued);
        EXPECT_EQ(again.num_attempts, 0);
        EXPECT_FALSE(again.cancel_requested);
        EXPECT_EQ(again.failure.message, "");
        EXPECT_TRUE(jobs_.succeed(claim().lease, {}));
        EXPECT_EQ(jobs_.get(job.id).state, JobState::Succeeded);
    }
}

TEST_F(JobStoreTest, RefusesToRetryWhatIsUnderWayOrSucceeded) {
    const Job job = enqueue(ready_dive());
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { jobs_.retry(job.id); }));
    const Lease lease = claim().lease;
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { jobs_.retry(job.id); }));
    jobs_.succeed(lease, {});
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { jobs_.retry(job.id); }));
}

TEST_F(JobStoreTest, ListsEveryJobOnceWhilePagesAreTurnedAndJobsCome) {
    const Dive dive = ready_dive();
    std::vector<std::string> before;
    for (int i = 0; i < 7; ++i) before.push_back(enqueue(dive).id);

    std::vector<std::string> seen;
    PageRequest page{.limit = 2};
    do {
        const auto part = jobs_.list({.kind = JobKind::Reconstruct}, page);
        for (const Job& job : part.items) seen.push_back(job.id);
        page.cursor = part.next_cursor;
        if (seen.size() < 7) enqueue(dive);
    } while (!page.cursor.empty() && seen.size() < 50);

    for (const std::string& id : before) EXPECT_EQ(std::count(seen.begin(), seen.end(), id), 1);
    EXPECT_EQ(std::set<std::string>(seen.begin(), seen.end()).size(), seen.size());
}

TEST_F(JobStoreTest, FiltersByProjectDiveStateAndKind) {
    const Dive wreck = ready_dive("wreck");
    const Dive reef = ready_dive("reef");
    const Job on_wreck = enqueue(wreck);
    const Job on_reef = enqueue(reef);
    jobs_.cancel(on_reef.id);
    const auto ids = [&](const JobFilter& filter) {
        std::vector<std::string> found;
        for (const Job& job : jobs_.list(filter, {}).items) found.push_back(job.id);
        return found;
    };

    EXPECT_THAT(ids({.dive_id = wreck.id, .kind = JobKind::Reconstruct}), ElementsAre(on_wreck.id));
    EXPECT_THAT(ids({.state = JobState::Cancelled}), ElementsAre(on_reef.id));
    EXPECT_EQ(ids({.project = "default"}).size(), 4u);
    EXPECT_TRUE(ids({.project = "other"}).empty());
}

TEST_F(JobStoreTest, RefusesAForgedCursorAndALimitOutOfRange) {
    for (const std::string cursor :
         {"x", ".", "1.", "-1.job_a", "1.job_a;--", "99999999999999999999.a", "1 .job_a", "1.JOB"})
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] {
            jobs_.list({}, {.cursor = cursor});
        })) << cursor;
    for (const int limit : {0, -1, 201})
        EXPECT_TRUE(
            throws_code(ErrorCode::InvalidArgument, [&] { jobs_.list({}, {.limit = limit}); }));
}

TEST_F(JobStoreTest, CountsJobsByState) {
    const Dive dive = ready_dive();
    enqueue(dive);
    enqueue(dive);

    EXPECT_THAT(jobs_.count_by_state(),
                ElementsAre(std::pair(JobState::Queued, 2), std::pair(JobState::Succeeded, 1)));
}

}  // namespace
}  // namespace divemesh::storage
