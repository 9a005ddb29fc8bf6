#include "storage/truth_store.hpp"

#include <gtest/gtest.h>

#include "storage/dive_removal.hpp"
#include "storage/project_usage.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

class TruthStoreTest : public StoreTest {
protected:
    CreatedTruth add(const Dive& dive,
                     const std::string& bytes,
                     TruthKind kind = TruthKind::GroundTruth) {
        return truths_.create(request(dive, bytes, kind));
    }
    NewTruth request(const Dive& dive,
                     const std::string& bytes,
                     TruthKind kind = TruthKind::GroundTruth) {
        const Upload upload = finished_upload(dive.project);
        return {.upload_id = upload.id,
                .project = dive.project,
                .dive_id = dive.id,
                .kind = kind,
                .name = "tracker.tum",
                .sha256 = sha256_hex(bytes),
                .size_bytes = 10,
                .blob = "truth/" + upload.id + "/file"};
    }

    TruthStore truths_{catalog_};
};

TEST_F(TruthStoreTest, AFileOfTruthBelongsToItsDiveAndItsUploadIsDone) {
    const Dive dive = ready_dive();
    const NewTruth wanted = request(dive, "poses");
    const TruthFile file = truths_.create(wanted).file;
    ASSERT_EQ(truths_.list(dive.id).size(), 1U);
    EXPECT_EQ(truths_.get(dive.id, file.id).sha256, sha256_hex("poses"));
    EXPECT_EQ(uploads_.get(wanted.upload_id).truth_id, file.id);
    EXPECT_TRUE(uploads_.list_open().empty());
    EXPECT_EQ(event_types(dive.id).back(), "dive.truth_added");
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { truths_.get("dive_other", file.id); }));
}

TEST_F(TruthStoreTest, TheSameUploadAndTheSameBytesAreOneFile) {
    const Dive dive = ready_dive();
    const NewTruth wanted = request(dive, "poses");
    const CreatedTruth first = truths_.create(wanted);
    const CreatedTruth again = truths_.create(wanted);
    EXPECT_EQ(again.file.id, first.file.id);
    EXPECT_FALSE(again.existed) << "its blob is this upload's own";
    const CreatedTruth same_bytes = add(dive, "poses");
    EXPECT_EQ(same_bytes.file.id, first.file.id);
    EXPECT_TRUE(same_bytes.existed);
    EXPECT_NE(add(dive, "poses", TruthKind::Reference).file.id, first.file.id);
    EXPECT_NE(add(dive, "better poses").file.id, first.file.id);
}

TEST_F(TruthStoreTest, NoDiveOfAnotherProjectAndNoneThatIsDeletedTakesAny) {
    const Dive dive = ready_dive();
    NewTruth of_others = request(dive, "poses");
    of_others.project = "others";
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { truths_.create(of_others); }));
    const NewTruth late = request(dive, "poses");
    DiveRemoval(catalog_).remove(dive.id, kLong, [](const Dive&) {});
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { truths_.create(late); }));
    EXPECT_TRUE(truths_.list(dive.id).empty());
}

TEST_F(TruthStoreTest, ItsBytesCountUntilItsBlobIsGone) {
    const Dive dive = ready_dive();
    const auto stored = [&] { return read_usage(catalog_, "default").stored_bytes; };
    const auto before = stored();
    const TruthFile file = add(dive, "poses").file;
    EXPECT_EQ(stored(), before + 10);
    truths_.remove(dive.id, file.id);
    EXPECT_TRUE(truths_.list(dive.id).empty());
    EXPECT_EQ(stored(), before + 10);
    ASSERT_EQ(truths_.removed(10).size(), 1U);
    truths_.forget(file.id);
    EXPECT_EQ(stored(), before);
    EXPECT_NE(add(dive, "poses").file.id, file.id) << "an id is never given again";
}

TEST_F(TruthStoreTest, GoesWithItsDive) {
    const Dive dive = ready_dive();
    const TruthFile file = add(dive, "poses").file;
    DiveRemoval removal(catalog_);
    removal.remove(dive.id, kOver, [](const Dive&) {});
    const auto expired = removal.expired(10);
    ASSERT_EQ(expired.size(), 1U);
    const auto prefixes = removal.blob_prefixes(expired[0]);
    EXPECT_EQ(
        std::count(prefixes.begin(), prefixes.end(), file.blob.substr(0, file.blob.size() - 4)), 1);
    EXPECT_TRUE(removal.forget(dive.id));
}

}  // namespace
}  // namespace divemesh::storage
