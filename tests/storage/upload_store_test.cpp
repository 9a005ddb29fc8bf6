#include "storage/upload_store.hpp"

#include <gmock/gmock.h>
#include <limits>

#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using testing::ElementsAre;
using UploadStoreTest = StoreTest;

TEST_F(UploadStoreTest, KeepsMetadataByteForByteAndMakesItsOwnIds) {
    const std::string metadata = "filename d3JlY2sudGFy,empty ,x \xff'\";--";

    const Upload upload = uploads_.create(
        {.id = "../mine", .project = "p", .length_bytes = 5, .metadata = metadata, .blob = "/etc"});

    const Upload stored = uploads_.get(upload.id);
    EXPECT_THAT(stored.id, testing::MatchesRegex("upload_[0-9a-v]+"));
    EXPECT_EQ(stored.blob, "uploads/" + stored.id);
    EXPECT_EQ(stored.metadata, metadata);
    EXPECT_EQ(stored.offset_bytes, 0);
    EXPECT_FALSE(stored.complete());
}

TEST_F(UploadStoreTest, TheOffsetNeverGoesDownNorBeyondTheLength) {
    const Upload upload = uploads_.create({.project = "p", .length_bytes = 10});

    EXPECT_EQ(uploads_.advance(upload.id, 6).offset_bytes, 6);
    EXPECT_EQ(uploads_.advance(upload.id, 4).offset_bytes, 6);
    EXPECT_TRUE(throws_code(ErrorCode::TooLarge, [&] { uploads_.advance(upload.id, 11); }));
    EXPECT_TRUE(uploads_.advance(upload.id, 10).complete());
    EXPECT_TRUE(uploads_.advance(upload.id, 10).complete());

    EXPECT_THAT(event_types(upload.id), ElementsAre("upload.created", "upload.completed"));
}

TEST_F(UploadStoreTest, AnUploadOfNothingIsCompleteAtOnce) {
    EXPECT_TRUE(uploads_.create({.project = "p", .length_bytes = 0}).complete());
}

TEST_F(UploadStoreTest, TakesLengthsUpTo63BitsAndNoNegativeOnes) {
    constexpr auto kLargest = std::numeric_limits<std::int64_t>::max();
    EXPECT_EQ(
        uploads_.get(uploads_.create({.project = "p", .length_bytes = kLargest}).id).length_bytes,
        kLargest);
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument,
                            [&] { uploads_.create({.project = "p", .length_bytes = -1}); }));
}

TEST_F(UploadStoreTest, RemovedUploadsAreGone) {
    const Upload upload = uploads_.create({.project = "p", .length_bytes = 10});

    uploads_.remove(upload.id);

    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { uploads_.get(upload.id); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { uploads_.remove(upload.id); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { uploads_.advance(upload.id, 1); }));
}

TEST_F(UploadStoreTest, SweepsOnlyWhatBecameNoDive) {
    const Upload forgotten = uploads_.create({.project = "default", .length_bytes = 10});
    create_dive("wreck");
    constexpr auto kEver = std::numeric_limits<std::int64_t>::max();

    const auto old = uploads_.list_older_than(kEver);

    ASSERT_EQ(old.size(), 1u);
    EXPECT_EQ(old[0].id, forgotten.id);
    EXPECT_TRUE(uploads_.list_older_than(forgotten.created_at_ms).empty());
}

}  // namespace
}  // namespace divemesh::storage
