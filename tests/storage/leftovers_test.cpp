#include "storage/leftovers.hpp"

#include <fstream>
#include <gmock/gmock.h>

#include "storage/blob_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

class LeftoversTest : public StoreTest {
protected:
    void put(const std::string& key) {
        std::ofstream(folder_ / "file") << "x";
        blobs_->put_file(key, folder_ / "file");
    }
    static std::string prefix_of(const Lease& lease) {
        return "jobs/" + lease.job_id + "/attempt-" + std::to_string(lease.attempt) + "-" +
               lease.lease_id + "/";
    }
    int clean() { return remove_leftovers(catalog_, *blobs_, std::chrono::milliseconds(-1), 100); }

    const std::unique_ptr<BlobStore> blobs_ = open_blob_store((folder_ / "blobs").string());
};

TEST_F(LeftoversTest, OnlyWhatCameToNothingIsRemoved) {
    enqueue(ready_dive());
    const Lease failed = claim().lease;
    put(prefix_of(failed) + "mesh.glb");
    jobs_.fail(failed, {ErrorCode::Unavailable, "crashed"});
    const Lease running = claim().lease;
    put(prefix_of(running) + "mesh.glb");

    EXPECT_EQ(clean(), 1);
    EXPECT_FALSE(blobs_->exists(prefix_of(failed) + "mesh.glb"));
    EXPECT_TRUE(blobs_->exists(prefix_of(running) + "mesh.glb"));
    jobs_.succeed(running, {});
    EXPECT_EQ(clean(), 0);
    EXPECT_TRUE(blobs_->exists(prefix_of(running) + "mesh.glb"));
}

TEST_F(LeftoversTest, APartialResultStaysUntilItsJobIsTriedAgain) {
    const Job job = enqueue(ready_dive());
    const Lease lease = claim().lease;
    put(prefix_of(lease) + "metrics.json");
    PartialResult partial;
    partial.artifacts = {{.name = "metrics.json", .blob = prefix_of(lease) + "metrics.json"}};
    partial.measured.verdict = Verdict::NotUsable;
    partial.measured.findings = {{Severity::Error, "no_surface", "", "no triangles", ""}};
    ASSERT_TRUE(jobs_.fail(lease, {ErrorCode::BadData, "no triangles"}, std::nullopt, partial));

    EXPECT_EQ(clean(), 0);
    EXPECT_EQ(jobs_.artifacts(job.id).size(), 1U);
    EXPECT_EQ(jobs_.get(job.id).verdict, Verdict::NotUsable);
    ASSERT_EQ(jobs_.get(job.id).findings.size(), 1U);
    EXPECT_EQ(jobs_.get(job.id).findings[0].code, "no_surface");

    jobs_.retry(job.id);
    EXPECT_TRUE(jobs_.artifacts(job.id).empty());
    EXPECT_FALSE(jobs_.get(job.id).verdict);
    EXPECT_EQ(clean(), 1);
    EXPECT_FALSE(blobs_->exists(prefix_of(lease) + "metrics.json"));
}

TEST_F(LeftoversTest, AnAttemptThatHasJustEndedMayStillBeWriting) {
    enqueue(ready_dive());
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "crashed"});
    EXPECT_EQ(remove_leftovers(catalog_, *blobs_, std::chrono::hours(1), 100), 0);
}

TEST_F(LeftoversTest, ForgetsEventsThatAreOld) {
    ready_dive();
    forget_events(catalog_, std::chrono::hours(1));
    EXPECT_FALSE(events_.since(0, "", 10).empty());
    forget_events(catalog_, std::chrono::milliseconds(-1));
    EXPECT_TRUE(events_.since(0, "", 10).empty());
    EXPECT_GT(events_.newest_sequence(), 0);
}

}  // namespace
}  // namespace divemesh::storage
