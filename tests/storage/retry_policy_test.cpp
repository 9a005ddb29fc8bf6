// What becomes of a job by the class of its failure, and when the clock is set.
#include <gmock/gmock.h>

#include "storage/job_ends.hpp"
#include "storage/job_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kHour_ms = 3'600'000;

class RetryPolicyTest : public StoreTest {
protected:
    // As if the catalog's clock had been set by so much.
    void set_clock(std::int64_t by_ms) {
        catalog_.transaction([&](soci::session& session) {
            session << "UPDATE jobs SET lease_expires_at_ms = lease_expires_at_ms - :by,"
                       " not_before_ms = CASE WHEN not_before_ms = 0 THEN 0"
                       "   ELSE not_before_ms - :by END",
                soci::use(by_ms, "by");
        });
    }
};

TEST_F(RetryPolicyTest, AJobThatRanOutOfMemoryRunsOnceMoreWithLessThenIsDead) {
    const Job job = enqueue(ready_dive(), 10);

    jobs_.fail(claim().lease, {ErrorCode::OutOfMemory, "killed"});
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Queued);
    const Claim again = claim();
    EXPECT_TRUE(again.job.lowered);
    jobs_.fail(again.lease, {ErrorCode::OutOfMemory, "killed"});

    const Job dead = jobs_.get(job.id);
    EXPECT_EQ(dead.state, JobState::Dead);
    EXPECT_EQ(dead.num_attempts, 2);
    EXPECT_THAT(dead.failure.remedy, HasSubstr("more memory"));
    EXPECT_FALSE(jobs_.retry(job.id).lowered);
}

TEST_F(RetryPolicyTest, AnAttemptThatItsWorkerFailedDoesNotCount) {
    const Job job = enqueue(ready_dive(), 1);
    for (int i = 1; i <= 5; ++i) {
        EXPECT_TRUE(
            jobs_.return_to_queue(claim().lease, {ErrorCode::OutOfSpace, "the disk is full"}));
        const Job waiting = jobs_.get(job.id);
        EXPECT_EQ(waiting.state, JobState::Queued);
        EXPECT_EQ(waiting.num_attempts, 0);
        EXPECT_EQ(waiting.failure.message, "the disk is full");
        EXPECT_EQ(jobs_.attempts(job.id).size(), static_cast<std::size_t>(i));
    }
    const Lease last = claim().lease;
    jobs_.cancel(job.id);
    EXPECT_TRUE(jobs_.return_to_queue(last, {ErrorCode::OutOfSpace, "the disk is full"}));
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Cancelled);
    EXPECT_FALSE(jobs_.return_to_queue(last, {ErrorCode::OutOfSpace, "the disk is full"}));
}

TEST_F(RetryPolicyTest, AJobIsPutBackForLongerEachTime) {
    const Job job = enqueue(ready_dive(), 1);
    JobStore jobs(catalog_, {.first = std::chrono::hours(1), .max = std::chrono::hours(8)});
    std::int64_t pause_ms = 0;
    for (int i = 0; i < 3; ++i) {
        jobs.return_to_queue(claim().lease, {ErrorCode::OutOfSpace, "the disk is full"});
        const std::int64_t due_ms = jobs.get(job.id).not_before_ms;
        catalog_.transaction([&](soci::session& session) {
            std::int64_t now_ms = Catalog::now_ms(session);
            EXPECT_GE(due_ms - now_ms, pause_ms - 60'000);
            pause_ms = due_ms - now_ms;
            session << "UPDATE jobs SET not_before_ms = 0";
        });
    }
    EXPECT_GE(pause_ms, 2 * kHour_ms - 60'000);
}

TEST_F(RetryPolicyTest, WantOfMemoryAtTheLastAttemptIsTriedOnceMoreWithLess) {
    const Job job = enqueue(ready_dive(), 2);
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "no network"});

    jobs_.fail(claim().lease, {ErrorCode::OutOfMemory, "killed"});
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Queued);
    const Claim last = claim();
    EXPECT_TRUE(last.job.lowered);
    jobs_.fail(last.lease, {ErrorCode::Unavailable, "no network"});

    EXPECT_EQ(jobs_.get(job.id).state, JobState::Dead);
    EXPECT_EQ(jobs_.attempts(job.id).size(), 3u);
}

TEST_F(RetryPolicyTest, AJobTakesLittleMemoryToTheEndOnceItRanOut) {
    enqueue(ready_dive(), 10);
    jobs_.fail(claim().lease, {ErrorCode::OutOfMemory, "killed"});
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "no network"});
    jobs_.release(claim().lease);

    EXPECT_TRUE(claim().job.lowered);
}

TEST_F(RetryPolicyTest, EveryFailureSaysWhatToDo) {
    const Dive dive = ready_dive();
    for (const ErrorCode code : {ErrorCode::InvalidArgument,
                                 ErrorCode::BadData,
                                 ErrorCode::NotFound,
                                 ErrorCode::Conflict,
                                 ErrorCode::TooLarge,
                                 ErrorCode::Unauthorized,
                                 ErrorCode::Forbidden,
                                 ErrorCode::Unsupported,
                                 ErrorCode::Cancelled,
                                 ErrorCode::OutOfSpace,
                                 ErrorCode::OutOfMemory,
                                 ErrorCode::Unavailable}) {
        const Job job = enqueue(dive, 1);
        while (!is_finished(jobs_.get(job.id).state)) jobs_.fail(claim().lease, {code, "why"});

        EXPECT_EQ(jobs_.get(job.id).failure.remedy, usual_remedy(code));
        EXPECT_NE(jobs_.attempts(job.id).at(0).failure.remedy, "");
    }
    const Job job = enqueue(dive, 1);
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "why", "do this"});
    EXPECT_EQ(jobs_.get(job.id).failure.remedy, "do this");
    EXPECT_EQ(jobs_.retry(job.id).failure.remedy, "");
}

TEST_F(RetryPolicyTest, AJobThatTakesItsWorkersDownAtOnceIsDeadAfterThree) {
    const Job job = enqueue(ready_dive(), 20);

    for (int i = 0; i < 3; ++i) {
        claim(kOver);
        jobs_.requeue_expired();
    }

    const Job dead = jobs_.get(job.id);
    EXPECT_EQ(dead.state, JobState::Dead);
    EXPECT_THAT(dead.failure.message, HasSubstr("3 workers in a row"));
    EXPECT_NE(dead.failure.remedy, "");
}

TEST_F(RetryPolicyTest, AWorkerThatWasHeardOfBreaksTheRow) {
    const Job job = enqueue(ready_dive(), 20);

    for (int i = 0; i < 6; ++i) {
        const Lease lease = claim(kOver).lease;
        if (i % 2 == 1) jobs_.renew(lease, kOver);
        jobs_.requeue_expired();
    }

    EXPECT_EQ(jobs_.get(job.id).state, JobState::Queued);
}

TEST_F(RetryPolicyTest, AClockSetForwardCostsALeaseAndNothingElse) {
    const Job job = enqueue(ready_dive());
    const Lease early = claim().lease;

    set_clock(kHour_ms);
    const Lease late = claim().lease;

    EXPECT_FALSE(jobs_.succeed(early, {}));
    EXPECT_TRUE(jobs_.succeed(late, {}));
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Succeeded);
}

TEST_F(RetryPolicyTest, AClockSetBackKeepsNoLeaseAliveForLongerThanItsLength) {
    enqueue(ready_dive());
    claim(std::chrono::milliseconds(0));  // the worker dies

    set_clock(-kHour_ms);

    EXPECT_TRUE(jobs_.claim("worker", kLong));
}

TEST_F(RetryPolicyTest, AClockSetBackKeepsNoRetryWaiting) {
    JobStore patient(catalog_, {.first = std::chrono::seconds(60)});
    enqueue(ready_dive());
    patient.fail(claim().lease, {ErrorCode::Unavailable, "no network"});
    EXPECT_FALSE(patient.claim("worker", kLong));

    set_clock(-kHour_ms);

    EXPECT_TRUE(patient.claim("worker", kLong));
}

}  // namespace
}  // namespace divemesh::storage
