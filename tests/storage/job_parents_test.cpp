#include <gmock/gmock.h>

#include "storage/job_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class JobParentsTest : public StoreTest {
protected:
    JobParentsTest() : dive_(ready_dive()) {}

    Job enqueue_behind(const std::vector<std::string>& parents) {
        NewJob job = work_on(dive_);
        job.parents = parents;
        return jobs_.enqueue(job).job;
    }
    JobState state(const Job& job) { return jobs_.get(job.id).state; }
    // True when the database takes the edge.
    bool waits_for(const Job& job, const Job& parent) {
        try {
            catalog_.transaction([&](soci::session& session) {
                session << "INSERT INTO job_parents (job_id, parent_id) VALUES (:job, :parent)",
                    soci::use(job.id, "job"), soci::use(parent.id, "parent");
            });
            return true;
        } catch (const soci::soci_error&) {
            return false;
        }
    }

    Dive dive_;
};

TEST_F(JobParentsTest, AJobStartsWhenAllItsParentsHaveSucceeded) {
    const Job first = enqueue(dive_);
    const Job second = enqueue(dive_);
    const Job child = enqueue_behind({first.id, second.id});
    EXPECT_EQ(child.state, JobState::Held);
    EXPECT_THAT(jobs_.get(child.id).parents, ElementsAre(first.id, second.id));

    jobs_.succeed(claim().lease, {});
    EXPECT_EQ(state(child), JobState::Held);
    EXPECT_EQ(claim().job.id, second.id);
    EXPECT_FALSE(jobs_.claim("worker", kLong));
    jobs_.cancel(second.id);
    EXPECT_EQ(state(child), JobState::Held);
}

TEST_F(JobParentsTest, BehindParentsThatHaveSucceededNothingIsWaitedFor) {
    const Job parent = enqueue(dive_);
    jobs_.succeed(claim().lease, {});

    const Job child = enqueue_behind({parent.id, parent.id});

    EXPECT_EQ(child.state, JobState::Queued);
    EXPECT_THAT(child.parents, ElementsAre(parent.id));
}

TEST_F(JobParentsTest, AJobFailsWithAParentThatFailsOrIsGivenUpOrCancelled) {
    const auto child_of = [&](const std::function<void(const Job&)>& end) {
        const Job parent = enqueue(dive_, 1);
        const Job child = enqueue_behind({parent.id});
        const Job grandchild = enqueue_behind({child.id});
        end(parent);
        EXPECT_EQ(state(grandchild), JobState::Failed);
        return jobs_.get(child.id);
    };

    const Job of_failed = child_of([&](const Job&) {
        jobs_.fail(claim().lease, {ErrorCode::BadData, "no frames"});
    });
    EXPECT_EQ(of_failed.state, JobState::Failed);
    EXPECT_EQ(of_failed.failure.code, ErrorCode::BadData);
    EXPECT_THAT(of_failed.failure.message, HasSubstr("no frames"));
    EXPECT_THAT(of_failed.failure.remedy, HasSubstr("retry job " + of_failed.parents[0]));

    const Job of_dead = child_of([&](const Job&) {
        jobs_.fail(claim().lease, {ErrorCode::Unavailable, "crashed"});
    });
    EXPECT_EQ(of_dead.state, JobState::Failed);
    const Job of_cancelled = child_of([&](const Job& parent) { jobs_.cancel(parent.id); });
    EXPECT_EQ(of_cancelled.state, JobState::Failed);
    EXPECT_THAT(of_cancelled.failure.message, HasSubstr("is cancelled"));
}

TEST_F(JobParentsTest, AJobBehindAParentAndItsChildFailsOnce) {
    const Job parent = enqueue(dive_);
    const Job child = enqueue_behind({parent.id});
    const Job both = enqueue_behind({parent.id, child.id});

    jobs_.cancel(parent.id);

    EXPECT_EQ(state(child), JobState::Failed);
    EXPECT_EQ(state(both), JobState::Failed);
    EXPECT_EQ(event_types(both.id).size(), 2u);
}

TEST_F(JobParentsTest, AChainOfAnyLengthFailsWithItsFirst) {
    const Job first = enqueue(dive_);
    Job last = first;
    for (int i = 0; i < 30; ++i) last = enqueue_behind({last.id});

    jobs_.cancel(first.id);

    const Failure failure = jobs_.get(last.id).failure;
    EXPECT_EQ(state(last), JobState::Failed);
    EXPECT_THAT(failure.message, HasSubstr(first.id));
    EXPECT_LT(failure.message.size(), 200u);
}

TEST_F(JobParentsTest, WhatFailedOnlyBecauseOfAParentWaitsForItAgainWhenThatIsRetried) {
    const Job parent = enqueue(dive_, 1);
    const Job child = enqueue_behind({parent.id});
    const Job both = enqueue_behind({parent.id, child.id});
    jobs_.fail(claim().lease, {ErrorCode::BadData, "no frames"});
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { jobs_.retry(child.id); }));

    jobs_.retry(parent.id);

    EXPECT_EQ(state(child), JobState::Held);
    EXPECT_EQ(jobs_.get(child.id).failure.message, "");
    EXPECT_EQ(state(both), JobState::Held);
    jobs_.succeed(claim().lease, {});
    EXPECT_EQ(state(child), JobState::Queued);
    EXPECT_EQ(state(both), JobState::Held);
}

TEST_F(JobParentsTest, RedriveRevivesWhatFailedOnlyBecauseOfTheDeadJob) {
    const Job parent = enqueue(dive_, 1);
    const Job other = enqueue(dive_, 1);
    const Job child = enqueue_behind({parent.id});
    const Job of_two = enqueue_behind({parent.id, other.id});
    const Job cancelled = enqueue_behind({parent.id});
    jobs_.cancel(cancelled.id);
    jobs_.cancel(other.id);
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "crashed"});
    ASSERT_EQ(state(parent), JobState::Dead);

    EXPECT_EQ(jobs_.redrive("", 10).size(), 1u);

    EXPECT_EQ(state(child), JobState::Held);
    EXPECT_EQ(state(of_two), JobState::Failed) << "its other parent is still cancelled";
    EXPECT_EQ(state(cancelled), JobState::Cancelled) << "a person has ended it";
}

TEST_F(JobParentsTest, WhatIsDoneByAnotherJobMeanwhileIsNotRevived) {
    const Job parent = enqueue(dive_, 1);
    NewJob wanted{.dive_id = dive_.id, .preset = "fast", .parents = {parent.id}};
    const Job child = jobs_.enqueue(wanted).job;
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "crashed"});
    wanted.parents.clear();
    const Job twin = jobs_.enqueue(wanted).job;
    ASSERT_NE(twin.id, child.id);

    jobs_.retry(parent.id);

    EXPECT_EQ(state(child), JobState::Failed);
}

TEST_F(JobParentsTest, NothingWaitsForWhatIsUnknownOrElsewhereOrCameToNothing) {
    const Job cancelled = enqueue(dive_);
    jobs_.cancel(cancelled.id);
    const Dive elsewhere = dives_.create(request(finished_upload("other"), "reef")).dive;
    const std::string foreign = jobs_.list({.project = "other"}, {}).items.at(0).id;

    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { enqueue_behind({cancelled.id}); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { enqueue_behind({"job_none"}); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { enqueue_behind({foreign}); }));
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument,
                            [&] { enqueue_behind(std::vector<std::string>(17, dive_.id)); }));
}

TEST_F(JobParentsTest, TheDatabaseRefusesACycle) {
    const Job first = enqueue(dive_);
    const Job second = enqueue_behind({first.id});
    const Job third = enqueue_behind({second.id});

    EXPECT_FALSE(waits_for(first, first));
    EXPECT_FALSE(waits_for(first, second));
    EXPECT_FALSE(waits_for(first, third));
    EXPECT_TRUE(waits_for(third, first));
}

TEST_F(JobParentsTest, APausedJobStaysHeldWhenItsParentsHaveSucceeded) {
    const Job parent = enqueue(dive_);
    const Job child = enqueue_behind({parent.id});
    jobs_.change(child.id, {.paused = true});

    jobs_.succeed(claim().lease, {});
    EXPECT_EQ(state(child), JobState::Held);

    EXPECT_EQ(jobs_.change(child.id, {.paused = false}).state, JobState::Queued);
}

}  // namespace
}  // namespace divemesh::storage
