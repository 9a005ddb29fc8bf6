#include "storage/backup.hpp"

#include <atomic>
#include <fstream>
#include <set>
#include <sys/stat.h>
#include <thread>

#include "storage/blob_store.hpp"
#include "storage/data_id.hpp"
#include "storage/truth_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;

// As if each blob were removed between two calls of the backup.
class VanishingBlobs : public BlobStore {
public:
    explicit VanishingBlobs(BlobStore& blobs) : blobs_(blobs) {}

    std::unique_ptr<StagedBlob> open_staged(const std::string& key,
                                            std::int64_t num_durable_bytes) override {
        return blobs_.open_staged(key, num_durable_bytes);
    }
    std::int64_t staged_size_bytes(const std::string& key) override {
        return blobs_.staged_size_bytes(key);
    }
    std::unique_ptr<BlobReader> read_staged(const std::string& key) override {
        return blobs_.read_staged(key);
    }
    void remove_staged(const std::string& key) override { blobs_.remove_staged(key); }
    void commit_staged(const std::string& staged_key, const std::string& key) override {
        blobs_.commit_staged(staged_key, key);
    }
    void put_file(const std::string& key, const fs::path& file) override {
        blobs_.put_file(key, file);
    }
    std::unique_ptr<BlobReader> open(const std::string& key) override {
        blobs_.remove(key);
        return blobs_.open(key);
    }
    fs::path local_copy(const std::string& key,
                        const fs::path& copy,
                        const std::string& sha256) override {
        return blobs_.local_copy(key, copy, sha256);
    }
    bool exists(const std::string& key) override { return blobs_.exists(key); }
    void remove(const std::string& key) override { blobs_.remove(key); }
    void remove_prefix(const std::string& prefix) override { blobs_.remove_prefix(prefix); }
    std::vector<std::string> children(const std::string& prefix) override {
        return blobs_.children(prefix);
    }
    std::int64_t free_bytes() override { return blobs_.free_bytes(); }
    std::string data_id() override { return blobs_.data_id(); }
    void set_data_id(const std::string& id) override { blobs_.set_data_id(id); }
    std::string location() const override { return blobs_.location(); }

private:
    BlobStore& blobs_;
};

class SqliteBackupTest : public StoreTest {
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

TEST_F(SqliteBackupTest, TruthThatCameLaterIsPartOfIt) {
    const Dive dive = stored_dive("a");
    const Upload upload = finished_upload();
    const std::string key = "truth/" + upload.id + "/file";
    std::ofstream(folder_ / "truth", std::ios::binary) << "poses";
    blobs_->put_file(key, folder_ / "truth");
    TruthStore(catalog_).create({.upload_id = upload.id,
                                 .project = dive.project,
                                 .dive_id = dive.id,
                                 .sha256 = sha256_hex("poses"),
                                 .size_bytes = 5,
                                 .blob = key});
    EXPECT_EQ(backup().num_blobs, 2);
    EXPECT_EQ(restore("copy").num_blobs, 2);
    EXPECT_TRUE(open_blob_store((folder_ / "copy" / "blobs").string())->exists(key));
}

TEST_F(SqliteBackupTest, WhatIsRestoredIsWhatWasThere) {
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

TEST_F(SqliteBackupTest, WhatIsRestoredHasAnIdOfItsOwn) {
    stored_dive("a");
    claim_data(catalog_, *blobs_);
    backup();
    restore("copy");

    Catalog catalog("sqlite://" + (folder_ / "copy/catalog.db").string(), Opening::ExistingOnly);
    const auto blobs = open_blob_store((folder_ / "copy/blobs").string());
    EXPECT_EQ(data_mismatch(catalog, *blobs), "");
    EXPECT_NE(blobs->data_id(), blobs_->data_id());
    EXPECT_NE(data_mismatch(catalog, *blobs_), "");
    claim_data(catalog, *blobs);
}

TEST_F(SqliteBackupTest, ACatalogIsRestoredBesideTheBlobsThatAreLeft) {
    stored_dive("a");
    claim_data(catalog_, *blobs_);
    backup();
    read_backup(file_, folder_ / "new.db", *blobs_);

    Catalog catalog("sqlite://" + (folder_ / "new.db").string());
    claim_data(catalog, *blobs_);
    EXPECT_EQ(data_mismatch(catalog, *blobs_), "");
}

TEST_F(SqliteBackupTest, OthersMayWriteWhileItIsMade) {
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

TEST_F(SqliteBackupTest, OverwritesNoCatalog) {
    stored_dive("a");
    backup();
    restore("copy");
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { restore("copy"); }));
}

TEST_F(SqliteBackupTest, RefusesWhatIsDamagedCutShortOrNoBackup) {
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

TEST_F(SqliteBackupTest, SaysWhatWasGoneAlready) {
    const Dive dive = stored_dive("a");
    blobs_->remove(dive.blob);
    EXPECT_EQ(backup().num_missing, 1);
    EXPECT_EQ(restore("copy").num_missing, 1);
}

TEST_F(SqliteBackupTest, WhatGoesWhileItIsMadeIsMissing) {
    stored_dive("a");
    VanishingBlobs blobs(*blobs_);

    const auto made = write_backup(catalog_, blobs, file_);

    EXPECT_EQ(made.num_missing, 1);
    EXPECT_EQ(made.num_blobs, 0);
    EXPECT_EQ(restore("copy").num_missing, 1);
}

TEST_F(SqliteBackupTest, ItsOwnerAloneMayReadItWhateverTheUmask) {
    stored_dive(std::string(3'000'000, 'a'));
    std::set<fs::perms> seen;
    std::atomic<bool> done = false;
    std::thread watcher([&] {
        while (!done)
            for (const char* suffix : {".catalog", ".catalog-wal", ".part"}) {
                std::error_code absent;
                const auto status = fs::status(file_.string() + suffix, absent);
                if (fs::is_regular_file(status)) seen.insert(status.permissions());
            }
    });
    const mode_t umask_before = umask(0);
    for (int i = 0; i < 5; ++i) backup();
    umask(umask_before);
    done = true;
    watcher.join();

    const auto private_mode = fs::perms::owner_read | fs::perms::owner_write;
    EXPECT_EQ(fs::status(file_).permissions(), private_mode);
    EXPECT_EQ(seen, std::set<fs::perms>{private_mode});
}

}  // namespace
}  // namespace divemesh::storage
