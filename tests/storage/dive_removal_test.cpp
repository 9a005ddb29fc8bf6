#include "storage/dive_removal.hpp"

#include <gmock/gmock.h>

#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

class DiveRemovalTest : public StoreTest {
protected:
    Dive remove(const Dive& dive, std::chrono::milliseconds keep = kLong) {
        return removal_.remove(dive.id, keep, [](const Dive&) {});
    }

    DiveRemoval removal_{catalog_};
};

TEST_F(DiveRemovalTest, NothingIsForgottenBeforeItHasExpired) {
    const Dive dive = ready_dive();
    remove(dive);
    EXPECT_TRUE(removal_.expired(10).empty());
    EXPECT_EQ(removal_.restore(dive.id).deleted_at_ms, 0);
}

TEST_F(DiveRemovalTest, WhatHasExpiredCannotBeRestoredAndLeavesNoRow) {
    const Dive dive = ready_dive("wreck");
    const Job job = enqueue(dive);
    jobs_.succeed(claim().lease, {{job.id, "mesh.glb", "model/gltf-binary", "00", 1, "jobs/x"}});
    enqueue(dive);
    remove(dive, std::chrono::milliseconds(0));

    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { removal_.restore(dive.id); }));
    ASSERT_EQ(removal_.expired(10).size(), 1U);
    EXPECT_THAT(removal_.blob_prefixes(dive), testing::Contains("jobs/" + job.id + "/"));
    removal_.forget(dive.id);

    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { dives_.get(dive.id); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { jobs_.get(job.id); }));
    EXPECT_TRUE(removal_.expired(10).empty());
    EXPECT_EQ(event_types(dive.id).back(), "dive.removed");
    ready_dive("wreck");
}

TEST_F(DiveRemovalTest, ARunningJobIsWaitedFor) {
    const Dive dive = ready_dive();
    enqueue(dive);
    const Claim claimed = claim();
    remove(dive, std::chrono::milliseconds(0));

    EXPECT_TRUE(removal_.expired(10).empty());
    EXPECT_TRUE(jobs_.renew(claimed.lease, kLong).cancel_requested);
    jobs_.fail(claimed.lease, {ErrorCode::Cancelled, "cancelled"});
    EXPECT_EQ(jobs_.get(claimed.job.id).state, JobState::Cancelled);
    EXPECT_EQ(removal_.expired(10).size(), 1U);
}

TEST_F(DiveRemovalTest, WhatRunsAgainMeanwhileIsNotForgotten) {
    const Dive dive = ready_dive();
    const Job job = enqueue(dive);
    remove(dive, std::chrono::milliseconds(0));
    ASSERT_EQ(removal_.expired(10).size(), 1U);
    catalog_.transaction([&](soci::session& session) {
        session << "UPDATE jobs SET state = 'queued' WHERE id = :id", soci::use(job.id, "id");
    });
    const Claim claimed = claim();

    EXPECT_FALSE(removal_.forget(dive.id));
    EXPECT_EQ(jobs_.get(job.id).state, JobState::Running);
    EXPECT_EQ(dives_.get(dive.id).id, dive.id);

    jobs_.release(claimed.lease);
    EXPECT_TRUE(removal_.forget(dive.id)) << "what waits goes with it";
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { dives_.get(dive.id); }));
}

TEST_F(DiveRemovalTest, WhatIsBroughtBackCountsAsADiveOfItsProject) {
    const Dive dive = ready_dive("wreck");
    remove(dive);
    const Dive other = ready_dive("reef");

    EXPECT_TRUE(throws_code(ErrorCode::OutOfQuota, [&] { removal_.restore(dive.id, 1); }));
    EXPECT_GT(dives_.get(dive.id).deleted_at_ms, 0);
    EXPECT_EQ(removal_.restore(other.id, 1).id, other.id) << "it was never gone";

    remove(other);
    EXPECT_EQ(removal_.restore(dive.id, 1).deleted_at_ms, 0);
}

TEST_F(DiveRemovalTest, WhoseCheckThrowsStays) {
    const Dive dive = ready_dive();
    EXPECT_THROW(
        removal_.remove(dive.id, kLong, [](const Dive&) { throw std::runtime_error("no"); }),
        std::runtime_error);
    EXPECT_EQ(dives_.get(dive.id).deleted_at_ms, 0);
}

}  // namespace
}  // namespace divemesh::storage
