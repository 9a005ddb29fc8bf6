#include "storage/upload_store.hpp"

#include <gmock/gmock.h>
#include <limits>

#include "storage/project_usage.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using testing::ElementsAre;
using UploadStoreTest = StoreTest;

// A database that takes UTF-8 alone keeps a sign in place of a byte that is none.
TEST_F(UploadStoreTest, KeepsMetadataByteForByteAndMakesItsOwnIds) {
    const std::string byte = on_postgresql() ? "\uFFFD" : "\xff";
    const std::string metadata = "filename d3JlY2sudGFy,empty ,x ü'\";--" + byte;

    const Upload upload =
        uploads_.create({.id = "../mine",
                         .project = "p",
                         .length_bytes = 5,
                         .metadata = metadata.substr(0, metadata.size() - byte.size()) + "\xff",
                         .blob = "/etc"});

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
    constexpr auto kMaxInt64 = std::numeric_limits<std::int64_t>::max();
    EXPECT_EQ(
        uploads_.get(uploads_.create({.project = "p", .length_bytes = kMaxInt64}).id).length_bytes,
        kMaxInt64);
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

    const auto open_in_p = [&](std::int64_t max_num_open) {
        uploads_.create({.project = "p", .length_bytes = 10},
                        {.max_open_of_project = max_num_open});
    };
    EXPECT_TRUE(throws_code(ErrorCode::TooMany, [&] { open_in_p(1); }));
    EXPECT_EQ(uploads_.list_open().size(), 2u);
    EXPECT_NO_THROW(open_in_p(2));
}

TEST_F(UploadStoreTest, OneTokenHasOnlySoManyOpen) {
    const UploadLimits limits{.max_open_of_project = 4, .max_open_of_token = 2};
    const auto create = [&](const std::string& token) {
        return uploads_.create({.project = "p", .token_id = token, .length_bytes = 10}, limits);
    };
    const Upload first = create("a");
    create("a");
    EXPECT_TRUE(throws_code(ErrorCode::TooMany, [&] { create("a"); }));
    create("b");
    uploads_.end(first.id, UploadEnd::Terminated);
    create("a");
    create("");  // where no token is asked for only the project counts
    EXPECT_TRUE(throws_code(ErrorCode::TooMany, [&] { create(""); }));
    EXPECT_EQ(uploads_.list_open().size(), 4u);
}

// Between the check of its parts and its own row, another final upload may have taken them.
TEST_F(UploadStoreTest, FinalUploadsOfTheSamePartsAtOnceCountEach) {
    const UploadLimits limits{.max_bytes_of_project = 250};
    std::vector<std::string> parts;
    for (int i = 0; i < 2; ++i) {
        const Upload part =
            uploads_.create({.project = "p", .length_bytes = 50, .concat = "partial"});
        parts.push_back(uploads_.advance(part.id, 50).id);
    }
    const auto final_of = [&](const std::string& metadata) {
        return uploads_.create_final({.project = "p",
                                      .length_bytes = 100,
                                      .metadata = metadata,
                                      .concat = "final;/api/v1/uploads/" + parts[0] +
                                                " /api/v1/uploads/%75" + parts[1].substr(1)},
                                     parts,
                                     limits);
    };
    const auto stored = [&] { return read_usage(catalog_, "p").stored_bytes; };
    const Upload first = final_of("a");
    EXPECT_EQ(stored(), 100) << "the parts account for it";
    EXPECT_EQ(final_of("a").id, first.id);
    const Upload second = final_of("b");
    EXPECT_EQ(stored(), 200);
    EXPECT_TRUE(throws_code(ErrorCode::OutOfQuota, [&] { final_of("c"); }));

    uploads_.end(second.id, UploadEnd::Terminated);
    EXPECT_EQ(stored(), 100);
    const Upload third = final_of("c");
    for (const Upload& whole : {first, third}) uploads_.advance(whole.id, 100);
    for (const auto& part : parts) uploads_.end(part, UploadEnd::Concatenated);
    EXPECT_EQ(stored(), 200) << "both are there";
    EXPECT_TRUE(throws_code(ErrorCode::Gone, [&] { final_of("d"); }));
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

// Quota 1000: one final of a part of 300 that names it twice, and no second one before that ends.
TEST_F(UploadStoreTest, WhatAFinalUploadRepeatsCountsBeforeItsBytesAreThere) {
    const Upload part = uploads_.create({.project = "p", .length_bytes = 300, .concat = "partial"});
    const auto create_final = [&](const std::string& metadata) {
        return uploads_.create_final(
            {.project = "p", .length_bytes = 600, .metadata = metadata, .concat = "final;/a /a"},
            {part.id, part.id},
            {.max_bytes_of_project = 1000});
    };
    const Upload first = create_final("first");
    EXPECT_EQ(read_usage(catalog_, "p").stored_bytes, 600);

    EXPECT_TRUE(throws_code(ErrorCode::OutOfQuota, [&] { create_final("second"); }));
    uploads_.end(first.id, UploadEnd::Terminated);
    create_final("second");
}

}  // namespace
}  // namespace divemesh::storage
