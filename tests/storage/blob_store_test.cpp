#include "storage/blob_store.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sys/resource.h>

#include "tests/storage/store_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;

class BlobStoreTest : public testing::Test {
protected:
    fs::path file_with(const std::string& bytes) const {
        const fs::path file = folder_ / "source";
        std::ofstream(file, std::ios::binary) << bytes;
        return file;
    }
    std::string read(BlobReader& reader) const {
        std::string bytes(static_cast<std::size_t>(reader.size_bytes()), ' ');
        EXPECT_EQ(reader.read_at(0, bytes), bytes.size());
        return bytes;
    }
    std::size_t num_files(const std::string& area) const {
        std::size_t count = 0;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / "data" / area))
            count += entry.is_regular_file();
        return count;
    }

    TemporaryFolder folder_;
    std::unique_ptr<BlobStore> blobs_ = open_blob_store((folder_ / "data").string());
};

// No file of this process grows beyond `bytes` meanwhile: the kernel's EFBIG stands for a full
// disk.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }

private:
    rlimit before_{};
    void (*handler_)(int);
};

TEST_F(BlobStoreTest, KeepsAFileUnderItsKey) {
    blobs_->put_file("jobs/job_1/attempt-1/mesh.glb", file_with("triangles"));

    EXPECT_TRUE(blobs_->exists("jobs/job_1/attempt-1/mesh.glb"));
    const auto reader = blobs_->open("jobs/job_1/attempt-1/mesh.glb");
    EXPECT_EQ(reader->size_bytes(), 9);
    char middle[4];
    EXPECT_EQ(reader->read_at(3, middle), 4u);
    EXPECT_EQ(std::string(middle, 4), "angl");
    EXPECT_EQ(reader->read_at(9, middle), 0u);
    EXPECT_EQ(num_files("tmp"), 0u);
    std::ifstream copy(blobs_->local_copy("jobs/job_1/attempt-1/mesh.glb", folder_ / "scratch"));
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(copy), {}), "triangles");
}

TEST_F(BlobStoreTest, WhatIsNotThereIsNotFound) {
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

TEST_F(BlobStoreTest, StagedBytesGoOnWhereTheyEnded) {
    {
        const auto staged = blobs_->open_staged("uploads/upload_1");
        staged->write(std::string("first "));
        EXPECT_EQ(staged->flush(), 6);
    }
    const auto reopened = open_blob_store("file://" + (folder_ / "data").string());
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

TEST_F(BlobStoreTest, RefusesKeysThatAreNotOurs) {
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

TEST_F(BlobStoreTest, FollowsNoLinkOutOfItsFolder) {
    fs::create_directories(folder_ / "outside");
    std::ofstream(folder_ / "outside/secret") << "secret";
    fs::create_directories(folder_ / "data/blobs/dives");
    fs::create_symlink(folder_ / "outside", folder_ / "data/blobs/dives/folder");
    fs::create_symlink(folder_ / "outside/secret", folder_ / "data/blobs/dives/file");

    EXPECT_ANY_THROW(blobs_->open("dives/folder/secret"));
    EXPECT_ANY_THROW(blobs_->open("dives/file"));
    EXPECT_ANY_THROW(blobs_->put_file("dives/folder/new", file_with("x")));
    blobs_->remove_prefix("dives/");
    EXPECT_TRUE(fs::exists(folder_ / "outside/secret"));
}

TEST_F(BlobStoreTest, DoesNotCopyThroughALinkInTheSource) {
    fs::create_symlink("/etc/passwd", folder_ / "link");

    EXPECT_ANY_THROW(blobs_->put_file("jobs/x", folder_ / "link"));
}

TEST_F(BlobStoreTest, RemovesAPrefixAndNothingThatOnlyBeginsLikeIt) {
    for (const std::string key :
         {"jobs/a/attempt-1/x", "jobs/a/attempt-1/deep/y", "jobs/a/attempt-10/x"})
        blobs_->put_file(key, file_with("x"));

    blobs_->remove_prefix("jobs/a/attempt-1/");

    EXPECT_FALSE(blobs_->exists("jobs/a/attempt-1/x"));
    EXPECT_FALSE(blobs_->exists("jobs/a/attempt-1/deep/y"));
    EXPECT_TRUE(blobs_->exists("jobs/a/attempt-10/x"));
}

TEST_F(BlobStoreTest, AFullDiskIsSaidSoAndLeavesNoHalfOfABlob) {
    const fs::path file = file_with(std::string(200'000, 'x'));
    {
        const FileSizeLimit full(100'000);
        EXPECT_TRUE(throws_code(ErrorCode::OutOfSpace, [&] { blobs_->put_file("jobs/x", file); }));
    }
    EXPECT_FALSE(blobs_->exists("jobs/x"));
    EXPECT_EQ(num_files("tmp"), 0u);
    blobs_->put_file("jobs/x", file);
}

TEST_F(BlobStoreTest, AnUploadThatFillsTheDiskKeepsWhatWasDurable) {
    const auto staged = blobs_->open_staged("uploads/u");
    staged->write(std::string(60'000, 'a'));
    EXPECT_EQ(staged->flush(), 60'000);
    {
        const FileSizeLimit full(100'000);
        EXPECT_TRUE(
            throws_code(ErrorCode::OutOfSpace, [&] { staged->write(std::string(60'000, 'b')); }));
    }
    EXPECT_GE(blobs_->staged_size_bytes("uploads/u"), 60'000);
    EXPECT_EQ(read(*blobs_->read_staged("uploads/u")).substr(0, 60'000), std::string(60'000, 'a'));
}

TEST_F(BlobStoreTest, SaysHowMuchSpaceIsFree) { EXPECT_GT(blobs_->free_bytes(), 0); }

TEST_F(BlobStoreTest, RefusesStoresItDoesNotSpeak) {
    for (const std::string url : {"s3://bucket", "ftp://host", ""})
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { open_blob_store(url); }));
}

}  // namespace
}  // namespace divemesh::storage
