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

TEST_F(UploadStoreTest, ALengthIsToldOnce) {
    const Upload upload = uploads_.create({.project = "p"});
    EXPECT_FALSE(uploads_.get(upload.id).length_bytes);
    uploads_.advance(upload.id, 7);

    EXPECT_TRUE(
        throws_code(ErrorCode::InvalidArgument, [&] { uploads_.set_length(upload.id, 6); }));
    EXPECT_TRUE(uploads_.set_length(upload.id, 7).complete());
    EXPECT_TRUE(uploads_.set_length(upload.id, 7).complete());
    EXPECT_TRUE(
        throws_code(ErrorCode::InvalidArgument, [&] { uploads_.set_length(upload.id, 8); }));

    EXPECT_THAT(event_types(upload.id), ElementsAre("upload.created", "upload.completed"));
}

TEST_F(UploadStoreTest, WhatEndedStaysEndedAndIsToldSo) {
    const Upload upload = uploads_.create({.project = "p", .length_bytes = 10});

    uploads_.end(upload.id, UploadEnd::Terminated);

    EXPECT_EQ(uploads_.get(upload.id).end, UploadEnd::Terminated);
    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { require_open(uploads_.get(upload.id)); }));
    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { uploads_.end(upload.id, UploadEnd::Expired); }));
    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { uploads_.advance(upload.id, 1); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { uploads_.get("upload_none"); }));
    EXPECT_FALSE(uploads_.expire(upload.id));
    EXPECT_THAT(event_types(upload.id), ElementsAre("upload.created", "upload.removed"));
}

TEST_F(UploadStoreTest, IsForgottenWhenItsBytesAreFreedAndNotBefore) {
    const Upload upload = uploads_.create({.project = "p", .length_bytes = 10});
    uploads_.end(upload.id, UploadEnd::Terminated);

    uploads_.forget_ended(-1);
    ASSERT_EQ(uploads_.list_unfreed().size(), 1u);
    uploads_.set_freed(upload.id);
    EXPECT_TRUE(uploads_.list_unfreed().empty());
    uploads_.forget_ended(60'000);
    EXPECT_TRUE(uploads_.get(upload.id).end);
    uploads_.forget_ended(-1);

    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { uploads_.get(upload.id); }));
}

TEST_F(UploadStoreTest, ExpiresWhatIsDueAndNoDive) {
    constexpr std::int64_t kNone = 1;
    const Upload due = uploads_.create({.project = "p", .length_bytes = 10, .lifetime_ms = kNone});
    const Upload other = uploads_.create({.project = "p", .length_bytes = 10});
    create_dive("wreck");
    while (uploads_.list_expired().empty()) {
    }

    EXPECT_THAT(uploads_.list_expired(), ElementsAre(due.id));
    EXPECT_FALSE(uploads_.expire(other.id));
    EXPECT_TRUE(uploads_.expire(due.id));
    EXPECT_FALSE(uploads_.expire(due.id));
    EXPECT_TRUE(uploads_.list_expired().empty());
    EXPECT_THAT(event_types(due.id), ElementsAre("upload.created", "upload.expired"));
}

TEST_F(UploadStoreTest, CountsWhatIsNeitherEndedNorADive) {
    uploads_.create({.project = "p", .length_bytes = 10});
    uploads_.create({.project = "q", .length_bytes = 10});
    const Upload ended = uploads_.create({.project = "p", .length_bytes = 10});
    uploads_.end(ended.id, UploadEnd::Terminated);
    create_dive("wreck");

    EXPECT_EQ(uploads_.num_open("p"), 1);
    EXPECT_EQ(uploads_.list_open().size(), 2u);
}

TEST_F(UploadStoreTest, FindsTheFinalUploadOfTheSameParts) {
    const Upload made = uploads_.create(
        {.project = "p", .length_bytes = 10, .metadata = "commit", .concat = "final;/a /b"});
    const auto find = [&](const char* project, const char* metadata, const char* concat) {
        return uploads_.find_final({.project = project, .metadata = metadata, .concat = concat});
    };
    EXPECT_EQ(find("p", "commit", "final;/a /b")->id, made.id);
    EXPECT_FALSE(find("q", "commit", "final;/a /b"));
    EXPECT_FALSE(find("p", "", "final;/a /b"));
    EXPECT_FALSE(find("p", "commit", "final;/b /a"));
    uploads_.end(made.id, UploadEnd::Terminated);
    EXPECT_FALSE(find("p", "commit", "final;/a /b"));
}

// Quota 1000: two finals of a part of 300, each of which names it twice, and no third before one
// ends.
TEST_F(UploadStoreTest, WhatAFinalUploadRepeatsCountsBeforeItsBytesAreThere) {
    uploads_.create({.project = "p", .length_bytes = 300, .concat = "partial"});
    const auto create_final = [&](const std::string& metadata) {
        return uploads_.create(
            {.project = "p", .length_bytes = 600, .metadata = metadata, .concat = "final;/a /a"},
            1000,
            300);
    };
    const Upload first = create_final("first");
    create_final("second");

    EXPECT_TRUE(throws_code(ErrorCode::OutOfQuota, [&] { create_final("third"); }));
    uploads_.end(first.id, UploadEnd::Terminated);
    create_final("third");
}

}  // namespace
}  // namespace divemesh::storage
