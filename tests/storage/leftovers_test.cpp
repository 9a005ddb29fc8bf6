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
