#include "storage/directory_blob_store.hpp"

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

class DirectoryBlobStoreTest : public testing::Test {
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

TEST_F(DirectoryBlobStoreTest, LeavesNoTemporaryFile) {
    blobs_->put_file("jobs/x", file_with("triangles"));
    EXPECT_EQ(num_files("blobs"), 1u);
    EXPECT_EQ(num_files("tmp"), 0u);
}

TEST_F(DirectoryBlobStoreTest, FollowsNoLinkOutOfItsFolder) {
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

TEST_F(DirectoryBlobStoreTest, AFullDiskIsSaidSoAndLeavesNoHalfOfABlob) {
    const fs::path file = file_with(std::string(200'000, 'x'));
    {
        const FileSizeLimit full(100'000);
        EXPECT_TRUE(throws_code(ErrorCode::OutOfSpace, [&] { blobs_->put_file("jobs/x", file); }));
    }
    EXPECT_FALSE(blobs_->exists("jobs/x"));
    EXPECT_EQ(num_files("tmp"), 0u);
    blobs_->put_file("jobs/x", file);
}

TEST_F(DirectoryBlobStoreTest, AnUploadThatFillsTheDiskKeepsWhatWasDurable) {
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

}  // namespace
}  // namespace divemesh::storage
