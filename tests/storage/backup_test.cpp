#include "storage/backup.hpp"

#include <fstream>

#include "storage/blob_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;

class BackupTest : public StoreTest {
protected:
    // A dive whose archive is `bytes`.
    Dive stored_dive(const std::string& bytes) {
        const fs::path file = folder_ / "archive";
        std::ofstream(file, std::ios::binary) << bytes;
        NewDive request = Stores::request(finished_upload(), bytes);
        request.archive_sha256 = sha256_hex(bytes);
        blobs_->put_file(request.blob, file);
        return dives_.create(request).dive;
    }
    BackupSummary backup() { return write_backup(catalog_, *blobs_, file_); }
    BackupSummary restore(const std::string& name) {
        const auto blobs = open_blob_store((folder_ / name / "blobs").string());
        return read_backup(file_, folder_ / name / "catalog.db", *blobs);
    }
    void damage(std::size_t offset) {
        std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(static_cast<std::streamoff>(offset));
        file.put('!');
    }

    const fs::path file_ = folder_ / "backup.tar";
    const std::unique_ptr<BlobStore> blobs_ = open_blob_store((folder_ / "blobs").string());
};

TEST_F(BackupTest, WhatIsRestoredIsWhatWasThere) {
    const Dive dive = stored_dive(std::string(3'000'000, 'a'));
    stored_dive("b");
    uploads_.create({.project = "default", .length_bytes = 10});

    const auto made = backup();
    const auto restored = restore("copy");

    EXPECT_EQ(made.num_blobs, 2);
    EXPECT_EQ(restored.num_blobs, 2);
    EXPECT_EQ(restored.num_bytes, made.num_bytes);
    EXPECT_EQ(restored.num_missing, 0);
    Catalog catalog("sqlite://" + (folder_ / "copy/catalog.db").string());
    EXPECT_EQ(DiveStore(catalog).get(dive.id).archive_sha256, dive.archive_sha256);
    EXPECT_EQ(DiveStore(catalog).list({}, {}).items.size(), 2U);
    const auto blobs = open_blob_store((folder_ / "copy/blobs").string());
    EXPECT_EQ(blobs->open(dive.blob)->size_bytes(), 3'000'000);
    EXPECT_FALSE(fs::exists(file_.string() + ".part"));
    EXPECT_FALSE(fs::exists(file_.string() + ".catalog"));
}

TEST_F(BackupTest, OthersMayWriteWhileItIsMade) {
    stored_dive("a");
    std::atomic<bool> done = false;
    std::thread writer([&] {
        while (!done) uploads_.create({.project = "default", .length_bytes = 1});
    });
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(backup().num_blobs, 1);
        EXPECT_EQ(restore("copy" + std::to_string(i)).num_blobs, 1);
    }
    done = true;
    writer.join();
}

TEST_F(BackupTest, OverwritesNoCatalog) {
    stored_dive("a");
    backup();
    restore("copy");
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { restore("copy"); }));
}

TEST_F(BackupTest, RefusesWhatIsDamagedCutShortOrNoBackup) {
    stored_dive(std::string(100'000, 'a'));
    backup();
    const auto size = fs::file_size(file_);
    damage(size - 60'000);  // in the archive's bytes
    EXPECT_TRUE(throws_code(ErrorCode::BadData, [&] { restore("damaged"); }));
    EXPECT_FALSE(fs::exists(folder_ / "damaged/catalog.db"));
    backup();
    fs::resize_file(file_, size - 110'000);  // before the end's entry, within the archive
    EXPECT_TRUE(throws_code(ErrorCode::BadData, [&] { restore("cut"); }));
    std::ofstream(file_, std::ios::trunc) << "not a tar";
    EXPECT_TRUE(throws_code(ErrorCode::BadData, [&] { restore("none"); }));
    fs::remove(file_);
    EXPECT_ANY_THROW(restore("nothing"));
}

TEST_F(BackupTest, SaysWhatWasGoneAlready) {
    const Dive dive = stored_dive("a");
    blobs_->remove(dive.blob);
    EXPECT_EQ(backup().num_missing, 1);
    EXPECT_EQ(restore("copy").num_missing, 1);
}

}  // namespace
}  // namespace divemesh::storage
