#include <gmock/gmock.h>

#include "storage/job_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using testing::ElementsAre;
using JobLeaseTest = StoreTest;

const Artifact kMesh{.name = "mesh.glb",
                     .media_type = "model/gltf-binary",
                     .sha256 = "ab",
                     .size_bytes = 3,
                     .blob = "jobs/j/mesh.glb"};

TEST_F(JobLeaseTest, ClaimsNothingFromAnEmptyQueue) { EXPECT_FALSE(jobs_.claim("worker", kLong)); }

TEST_F(JobLeaseTest, ClaimHandsOutJobDiveAndLease) {
    const Dive dive = ready_dive();
    const Job job = enqueue(dive);

    const Claim claimed = claim();

    EXPECT_EQ(claimed.job.id, job.id);
    EXPECT_EQ(claimed.job.state, JobState::Running);
    EXPECT_EQ(claimed.job.num_attempts, 1);
    EXPECT_EQ(claimed.dive.id, dive.id);
    EXPECT_EQ(claimed.lease.job_id, job.id);
    EXPECT_EQ(claimed.lease.lease_id.size(), 32u);
    EXPECT_FALSE(jobs_.claim("another", kLong));
}

TEST_F(JobLeaseTest, ClaimsByPriorityThenAgeAndIntakeBeforeAllOthers) {
    const Dive dive = ready_dive();
    const Job first = enqueue(dive);
    const Job second = enqueue(dive);
    const Job urgent = jobs_.enqueue({.dive_id = dive.id, .priority = 100}).job;
    create_dive("reef");

    std::vector<std::string> order;
    for (int i = 0; i < 4; ++i) {
        const Claim claimed = claim();
        order.push_back(claimed.job.kind == JobKind::Intake ? "intake" : claimed.job.id);
    }

    EXPECT_THAT(order, ElementsAre("intake", urgent.id, first.id, second.id));
}

// Many are queued within one millisecond of the catalog's clock.
TEST_F(JobLeaseTest, JobsOfOneMillisecondAreClaimedInTheOrderTheyCame) {
    const Dive dive = ready_dive();
    std::vector<std::string> queued;
    for (int i = 0; i < 30; ++i) queued.push_back(enqueue(dive).id);

    std::vector<std::string> claimed;
    for (int i = 0; i < 30; ++i) claimed.push_back(claim().job.id);

    EXPECT_EQ(claimed, queued);
}

TEST_F(JobLeaseTest, ArtifactsBecomeVisibleWithTheSuccess) {
    const Job job = enqueue(ready_dive());
    const Lease lease = claim().lease;
    EXPECT_TRUE(jobs_.artifacts(job.id).empty());

    EXPECT_TRUE(jobs_.succeed(lease, {kMesh}));

    EXPECT_EQ(jobs_.get(job.id).state, JobState::Succeeded);
    EXPECT_EQ(jobs_.get(job.id).progress.fraction, 1.0);
    EXPECT_EQ(jobs_.artifacts(job.id).size(), 1u);
    const Artifact stored = jobs_.artifact(job.id, "mesh.glb");
    EXPECT_EQ(stored.job_id, job.id);
    EXPECT_EQ(stored.size_bytes, 3);
    EXPECT_EQ(stored.blob, kMesh.blob);
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { jobs_.artifact(job.id, "x"); }));
}

TEST_F(JobLeaseTest, NothingOfAPublishThatBreaksHalfWayIsVisible) {
    const Job job = enqueue(ready_dive());
    const Lease lease = claim().lease;

    EXPECT_ANY_THROW(jobs_.succeed(lease, {kMesh, kMesh}));  // one name twice

    EXPECT_TRUE(jobs_.artifacts(job.id).empty());
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Running);
}

TEST_F(JobLeaseTest, AStaleLeaseChangesNothing) {
    const auto [stale, winner] = overtaken_worker();
    const auto newest = events_.newest_sequence();

    EXPECT_FALSE(jobs_.renew(stale, kLong).valid);
    EXPECT_FALSE(jobs_.report_progress(stale, {.fraction = 0.9}));
    EXPECT_FALSE(jobs_.append_log(stale, "late"));
    EXPECT_FALSE(jobs_.succeed(stale, {kMesh}));
    EXPECT_FALSE(jobs_.finish_intake(stale, {}));
    EXPECT_FALSE(jobs_.fail(stale, {ErrorCode::BadData, "late"}));
    EXPECT_FALSE(jobs_.release(stale));

    EXPECT_EQ(events_.newest_sequence(), newest);
    const Job job = jobs_.get(winner.job_id);
    EXPECT_EQ(job.state, JobState::Running);
    EXPECT_EQ(job.progress.fraction, 0.0);
    EXPECT_TRUE(jobs_.renew(winner, kLong).valid);
    EXPECT_TRUE(jobs_.succeed(winner, {kMesh}));
    EXPECT_FALSE(jobs_.succeed(winner, {kMesh}));
}

TEST_F(JobLeaseTest, TheRightAttemptWithAGuessedLeaseIdChangesNothing) {
    enqueue(ready_dive());
    Lease lease = claim().lease;
    lease.lease_id = std::string(32, '0');

    EXPECT_FALSE(jobs_.fail(lease, {ErrorCode::BadData, "not mine"}));
}

TEST_F(JobLeaseTest, AnExpiredLeaseGivesTheJobToTheNextWorkerAtOnce) {
    const auto [stale, winner] = overtaken_worker();

    EXPECT_EQ(winner.job_id, stale.job_id);
    EXPECT_EQ(winner.attempt, stale.attempt + 1);
    EXPECT_NE(winner.lease_id, stale.lease_id);
    const auto attempts = jobs_.attempts(winner.job_id);
    ASSERT_EQ(attempts.size(), 2u);
    EXPECT_EQ(attempts[0].state, AttemptState::LeaseLost);
    EXPECT_GT(attempts[0].finished_at_ms, 0);
    EXPECT_EQ(attempts[1].state, AttemptState::Running);
}

TEST_F(JobLeaseTest, AJobThatKeepsLosingItsWorkersIsGivenUp) {
    const Job job = enqueue(ready_dive(), 2);
    claim(kOver);
    claim(kOver);

    EXPECT_EQ(jobs_.requeue_expired(), 1);

    EXPECT_EQ(jobs_.get(job.id).state, JobState::Dead);
    EXPECT_THAT(jobs_.get(job.id).failure.message, testing::HasSubstr("lease"));
}

TEST_F(JobLeaseTest, RenewingKeepsALeaseFromExpiring) {
    enqueue(ready_dive());
    const Lease lease = claim(std::chrono::milliseconds(0)).lease;

    EXPECT_TRUE(jobs_.renew(lease, kLong).valid);

    EXPECT_EQ(jobs_.requeue_expired(), 0);
}

TEST_F(JobLeaseTest, BadDataFailsAtOnce) {
    const Dive dive = ready_dive();
    for (const ErrorCode code : {ErrorCode::BadData,
                                 ErrorCode::InvalidArgument,
                                 ErrorCode::TooLarge,
                                 ErrorCode::Unsupported}) {
        const Job job = enqueue(dive);
        jobs_.fail(claim().lease, {code, "frame 7: no baseline"});

        EXPECT_EQ(jobs_.get(job.id).state, JobState::Failed);
        EXPECT_EQ(jobs_.get(job.id).failure.message, "frame 7: no baseline");
        EXPECT_FALSE(jobs_.claim("worker", kLong));
    }
}

TEST_F(JobLeaseTest, OtherFailuresAreTriedAgainUntilTheAttemptsAreUsedUp) {
    const Job job = enqueue(ready_dive(), 2);

    jobs_.fail(claim().lease, {ErrorCode::OutOfSpace, "disk full"});
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Queued);
    EXPECT_EQ(jobs_.get(job.id).failure.message, "disk full");
    jobs_.fail(claim().lease, {ErrorCode::OutOfSpace, "disk full"});

    EXPECT_EQ(jobs_.get(job.id).state, JobState::Dead);
    EXPECT_EQ(jobs_.attempts(job.id).at(1).failure.code, ErrorCode::OutOfSpace);
}

TEST_F(JobLeaseTest, PausesGrowAndDifferBetweenJobs) {
    JobStore patient(catalog_, {.first = std::chrono::hours(1), .max = std::chrono::hours(10)});
    const Job job = enqueue(ready_dive());
    patient.fail(claim().lease, {ErrorCode::Unavailable, "no network"});

    const Job waiting = jobs_.get(job.id);
    const std::int64_t pause_ms = waiting.not_before_ms - waiting.started_at_ms;
    EXPECT_GE(pause_ms, 1'800'000);
    EXPECT_LE(pause_ms, 3'700'000);
    EXPECT_FALSE(patient.claim("worker", kLong));
}

TEST_F(JobLeaseTest, AnAttemptGivenBackIsNotCounted) {
    const Job job = enqueue(ready_dive(), 1);

    EXPECT_TRUE(jobs_.release(claim().lease));

    EXPECT_EQ(jobs_.get(job.id).state, JobState::Queued);
    EXPECT_EQ(jobs_.get(job.id).num_attempts, 0);
    EXPECT_EQ(jobs_.attempts(job.id).at(0).state, AttemptState::Released);
    EXPECT_EQ(claim().lease.attempt, 2);
}

TEST_F(JobLeaseTest, AnAttemptEndedFromOutsideIsTriedAgain) {
    const Job job = enqueue(ready_dive());

    jobs_.fail(claim().lease, {ErrorCode::Cancelled, "cancelled"});

    EXPECT_EQ(jobs_.get(job.id).state, JobState::Queued);
}

TEST_F(JobLeaseTest, AnIntakeThatFailsForGoodRefusesTheDive) {
    const CreatedDive created = create_dive("wreck", "standard");

    jobs_.fail(claim().lease, {ErrorCode::BadData, "not an archive"});

    EXPECT_EQ(dives_.get(created.dive.id).state, DiveState::Refused);
    EXPECT_EQ(dives_.findings(created.dive.id).at(0).message, "not an archive");
    EXPECT_EQ(jobs_.get(created.job_id).state, JobState::Failed);
}

TEST_F(JobLeaseTest, TheLogIsCappedAndSaysSo) {
    const Job job = enqueue(ready_dive());
    const Lease lease = claim().lease;

    for (int i = 0; i < 8; ++i) EXPECT_TRUE(jobs_.append_log(lease, std::string(50'000, 'x')));

    const std::string log = jobs_.log(job.id);
    EXPECT_LT(log.size(), 270'000u);
    EXPECT_THAT(log, testing::EndsWith("cut off here]\n"));
}

TEST_F(JobLeaseTest, ProgressIsKeptAndOnlyItsNewestEvent) {
    const Job job = enqueue(ready_dive());
    const Lease lease = claim().lease;

    for (int i = 1; i <= 5; ++i)
        jobs_.report_progress(lease, {.stage = "track", .fraction = i / 10.0, .frames_done = i});

    EXPECT_EQ(jobs_.get(job.id).progress.frames_done, 5);
    EXPECT_THAT(event_types(job.id), ElementsAre("job.state", "job.state", "job.progress"));
}

TEST_F(JobLeaseTest, EveryChangeOfStateHasItsEventInOrder) {
    const Job job = enqueue(ready_dive());
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "no network"});
    jobs_.succeed(claim().lease, {});

    std::vector<std::string> states;
    std::int64_t last = 0;
    for (const Event& event : events_.since(0, "default", 100)) {
        EXPECT_EQ(event.sequence, last + 1);
        last = event.sequence;
        if (event.subject == job.id) states.push_back(event.data.at("state"));
    }
    EXPECT_THAT(states, ElementsAre("queued", "running", "queued", "running", "succeeded"));
    EXPECT_EQ(events_.newest_sequence(), last);
    EXPECT_TRUE(events_.since(last, "", 100).empty());
    EXPECT_TRUE(events_.since(0, "other", 100).empty());
}

}  // namespace
}  // namespace divemesh::storage
