#include "storage/blob_store.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "schemas/content_hash.hpp"
#include "storage/ids.hpp"
#include "storage/s3_blob_store.hpp"
#include "tests/storage/s3_server.hpp"
#include "tests/storage/store_fixture.hpp"
#include "tests/temporary_folder.hpp"

// What every engine of the blob store promises. An object store is started once for all tests.
namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;

enum class Engine { Directory, S3rver, Ceph };

S3Server* server_of(Engine engine) {
    if (engine == Engine::Ceph) return S3Server::shared_ceph();
    static const std::unique_ptr<S3Server> kServer = S3Server::start_s3rver();
    return kServer.get();
}

class AnyBlobStoreTest : public testing::TestWithParam<Engine> {
protected:
    void SetUp() override {
        if (GetParam() == Engine::Ceph && server_of(GetParam()) == nullptr)
            GTEST_SKIP() << "needs Ceph: apt-get install ceph-mon ceph-osd radosgw ceph-common";
        if (GetParam() == Engine::S3rver && server_of(GetParam()) == nullptr)
            GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
        blobs_ = open();
    }

    // Opens the store of this test anew.
    std::unique_ptr<BlobStore> open() const {
        if (GetParam() == Engine::Directory) return open_blob_store((folder_ / "data").string());
        const S3Server& server = *server_of(GetParam());
        return open_s3_blob_store(
            parse_s3_url(server.url(prefix_)), server.credentials(), folder_ / "staged");
    }
    fs::path file_with(const std::string& bytes) const {
        const fs::path file = folder_ / "source";
        std::ofstream(file, std::ios::binary) << bytes;
        return file;
    }
    static std::string read(BlobReader& reader) {
        std::string bytes(static_cast<std::size_t>(reader.size_bytes()), ' ');
        EXPECT_EQ(reader.read_at(0, bytes), bytes.size());
        return bytes;
    }
    static std::string content_of(const fs::path& file) {
        std::ifstream stream(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }

    std::string prefix_ = "test-" + random_hex(8);
    TemporaryFolder folder_;
    std::unique_ptr<BlobStore> blobs_;
};

TEST_P(AnyBlobStoreTest, KeepsAFileUnderItsKey) {
    blobs_->put_file("jobs/job_1/attempt-1/mesh.glb", file_with("triangles"));

    EXPECT_TRUE(blobs_->exists("jobs/job_1/attempt-1/mesh.glb"));
    const auto reader = blobs_->open("jobs/job_1/attempt-1/mesh.glb");
    EXPECT_EQ(reader->size_bytes(), 9);
    char middle[4];
    EXPECT_EQ(reader->read_at(3, middle), 4u);
    EXPECT_EQ(std::string(middle, 4), "angl");
    EXPECT_EQ(reader->read_at(9, middle), 0u);
    EXPECT_EQ(content_of(blobs_->local_copy(
                  "jobs/job_1/attempt-1/mesh.glb", folder_ / "copy", sha256_hex("triangles"))),
              "triangles");
}

TEST_P(AnyBlobStoreTest, WhatIsNotThereIsNotFound) {
    EXPECT_FALSE(blobs_->exists("dives/x"));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { blobs_->open("dives/x"); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { blobs_->read_staged("uploads/x"); }));
    EXPECT_TRUE(
        throws_code(ErrorCode::NotFound, [&] { blobs_->local_copy("dives/x", folder_.path()); }));
    EXPECT_TRUE(
        throws_code(ErrorCode::NotFound, [&] { blobs_->commit_staged("uploads/x", "dives/x"); }));
    EXPECT_TRUE(
        throws_code(ErrorCode::NotFound, [&] { blobs_->put_file("dives/x", folder_ / "none"); }));
    blobs_->remove("dives/x");
    blobs_->remove_staged("uploads/x");
    blobs_->remove_prefix("dives/");
}

TEST_P(AnyBlobStoreTest, StagedBytesGoOnWhereTheyEnded) {
    {
        const auto staged = blobs_->open_staged("uploads/upload_1");
        staged->write(std::string("first "));
        EXPECT_EQ(staged->flush(), 6);
    }
    const auto reopened = open();
    EXPECT_EQ(reopened->staged_size_bytes("uploads/upload_1"), 6);
    const auto staged = reopened->open_staged("uploads/upload_1");
    staged->write(std::string("second"));
    staged->flush();
    EXPECT_EQ(read(*reopened->read_staged("uploads/upload_1")), "first second");

    reopened->commit_staged("uploads/upload_1", "dives/upload_1/archive");
    reopened->commit_staged("uploads/upload_1", "dives/upload_1/archive");  // asked again

    EXPECT_EQ(read(*blobs_->open("dives/upload_1/archive")), "first second");
    EXPECT_EQ(blobs_->staged_size_bytes("uploads/upload_1"), 0);
}

TEST_P(AnyBlobStoreTest, RefusesKeysThatAreNotOurs) {
    const fs::path file = file_with("x");
    for (const std::string& key : {std::string(""),
                                   std::string("/etc/passwd"),
                                   std::string("../x"),
                                   std::string("a/../../x"),
                                   std::string("a/./b"),
                                   std::string("a//b"),
                                   std::string("a/"),
                                   std::string("A"),
                                   std::string("a b"),
                                   std::string("a\\b"),
                                   std::string("a\0b", 3),
                                   std::string("%2e%2e/x"),
                                   std::string("\xc3\xa4"),
                                   std::string(201, 'a'),
                                   std::string(600, 'a').replace(300, 1, 1, '/')}) {
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { blobs_->put_file(key, file); }))
            << key;
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { blobs_->open(key); })) << key;
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { blobs_->open_staged(key); }))
            << key;
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { blobs_->remove(key); })) << key;
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] {
            blobs_->remove_prefix(key + "/");
        })) << key;
    }
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { blobs_->remove_prefix("jobs"); }));
}

TEST_P(AnyBlobStoreTest, DoesNotCopyThroughALinkInTheSource) {
    fs::create_symlink("/etc/passwd", folder_ / "link");

    EXPECT_ANY_THROW(blobs_->put_file("jobs/x", folder_ / "link"));
}

TEST_P(AnyBlobStoreTest, RemovesAPrefixAndNothingThatOnlyBeginsLikeIt) {
    for (const std::string key :
         {"jobs/a/attempt-1/x", "jobs/a/attempt-1/deep/y", "jobs/a/attempt-10/x"})
        blobs_->put_file(key, file_with("x"));

    blobs_->remove_prefix("jobs/a/attempt-1/");

    EXPECT_FALSE(blobs_->exists("jobs/a/attempt-1/x"));
    EXPECT_FALSE(blobs_->exists("jobs/a/attempt-1/deep/y"));
    EXPECT_TRUE(blobs_->exists("jobs/a/attempt-10/x"));
}

TEST_P(AnyBlobStoreTest, SaysHowMuchSpaceIsFree) { EXPECT_GT(blobs_->free_bytes(), 0); }

// As by a server that was killed when the blob was there and the staged bytes still were, too.
TEST_P(AnyBlobStoreTest, CommitsAgainWhatAKilledServerHasCommitted) {
    for (int i = 0; i < 2; ++i) {
        blobs_->open_staged("uploads/u")->write(std::string("recording"));
        blobs_->commit_staged("uploads/u", "dives/u/archive");
        EXPECT_EQ(blobs_->staged_size_bytes("uploads/u"), 0);
    }
    EXPECT_EQ(read(*blobs_->open("dives/u/archive")), "recording");
}

TEST_P(AnyBlobStoreTest, ReplacesABlob) {
    blobs_->put_file("dives/x", file_with("first"));
    blobs_->put_file("dives/x", file_with("second one"));
    EXPECT_EQ(read(*blobs_->open("dives/x")), "second one");
}

TEST_P(AnyBlobStoreTest, KeepsAnEmptyFile) {
    blobs_->put_file("dives/x", file_with(""));
    EXPECT_TRUE(blobs_->exists("dives/x"));
    EXPECT_EQ(read(*blobs_->open("dives/x")), "");
    EXPECT_EQ(fs::file_size(blobs_->local_copy("dives/x", folder_ / "copy", sha256_hex(""))), 0U);
}

// More than two parts and more than two ranges, the last ones not whole.
TEST_P(AnyBlobStoreTest, KeepsWhatIsLargerThanAPart) {
    std::string bytes;
    for (std::uint32_t i = 0; bytes.size() < (std::size_t{40} << 20) + 12'345; ++i)
        bytes += sha256_hex(std::to_string(i));
    blobs_->open_staged("uploads/u")->write(bytes);
    blobs_->commit_staged("uploads/u", "dives/u/archive");

    const auto reader = blobs_->open("dives/u/archive");
    ASSERT_EQ(reader->size_bytes(), std::ssize(bytes));
    EXPECT_EQ(read(*reader), bytes);
    for (const std::int64_t offset :
         {std::int64_t{16} << 20, std::int64_t{7}, std::ssize(bytes) - 5}) {
        std::string some(1000, ' ');
        some.resize(reader->read_at(offset - 3, some));
        EXPECT_EQ(some, bytes.substr(static_cast<std::size_t>(offset - 3), 1000));
    }
    const auto copy = blobs_->local_copy("dives/u/archive", folder_ / "copy", sha256_hex(bytes));
    EXPECT_EQ(content_of(copy), bytes);
}

TEST_P(AnyBlobStoreTest, ListsWhatIsDirectlyBelowAPrefix) {
    for (const std::string key : {"jobs/a/x", "jobs/a/b/y", "jobs/a/b/z", "jobs/ab/x"})
        blobs_->put_file(key, file_with("x"));
    EXPECT_EQ(blobs_->children("jobs/a/"), (std::vector<std::string>{"b", "x"}));
    EXPECT_EQ(blobs_->children("jobs/"), (std::vector<std::string>{"a", "ab"}));
    EXPECT_TRUE(blobs_->children("dives/").empty());
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { blobs_->children("../"); }));
}

// An object store lists and removes a thousand at a time.
TEST_P(AnyBlobStoreTest, RemovesMoreThanAPageOfBlobs) {
    // On versions of Node with OpenSSL 3, s3rver cannot list a second page.
    const int count = GetParam() == Engine::S3rver ? 900 : 1005;
    const fs::path file = file_with("x");
    for (int i = 0; i < count; ++i) blobs_->put_file("jobs/a/" + std::to_string(i), file);
    blobs_->put_file("jobs/b/x", file);
    EXPECT_EQ(blobs_->children("jobs/a/").size(), static_cast<std::size_t>(count));
    blobs_->remove_prefix("jobs/a/");
    EXPECT_TRUE(blobs_->children("jobs/a/").empty());
    EXPECT_TRUE(blobs_->exists("jobs/b/x"));
}

TEST_P(AnyBlobStoreTest, KeepsTheIdOfItsData) {
    EXPECT_EQ(blobs_->data_id(), "");
    blobs_->set_data_id("one");
    blobs_->set_data_id("two");
    EXPECT_EQ(blobs_->data_id(), "two");
    EXPECT_EQ(open()->data_id(), "two");
    EXPECT_TRUE(blobs_->children("dives/").empty());
}

INSTANTIATE_TEST_SUITE_P(Directory, AnyBlobStoreTest, testing::Values(Engine::Directory));
INSTANTIATE_TEST_SUITE_P(S3rver, AnyBlobStoreTest, testing::Values(Engine::S3rver));
INSTANTIATE_TEST_SUITE_P(Ceph, AnyBlobStoreTest, testing::Values(Engine::Ceph));

TEST(BlobStoreTest, RefusesStoresItDoesNotSpeak) {
    for (const std::string url : {"ftp://host", "s3://", ""})
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { open_blob_store(url); }));
}

}  // namespace
}  // namespace divemesh::storage
