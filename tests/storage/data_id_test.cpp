#include "storage/data_id.hpp"

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>

#include "schemas/error.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class DataIdTest : public StoreTest {
protected:
    std::unique_ptr<BlobStore> open(const std::string& name) const {
        return open_blob_store((blobs_folder_ / name).string());
    }
    // Makes a dive whose archive is in the store.
    void make_dive(BlobStore& blobs) {
        std::ofstream(blobs_folder_ / "file") << "archive";
        blobs.put_file(create_dive("wreck").dive.blob, blobs_folder_ / "file");
    }

    TemporaryFolder blobs_folder_;
    std::unique_ptr<BlobStore> blobs_ = open("blobs");
};

class SqliteDataIdTest : public DataIdTest {};

TEST_F(DataIdTest, NewDataGetAnIdAndKeepIt) {
    EXPECT_FALSE(has_data_id(catalog_));
    claim_data(catalog_, *blobs_);
    const std::string id = blobs_->data_id();

    EXPECT_EQ(id.size(), 32U);
    EXPECT_TRUE(has_data_id(catalog_));
    claim_data(catalog_, *blobs_);
    EXPECT_EQ(open("blobs")->data_id(), id);
    EXPECT_EQ(data_mismatch(catalog_, *blobs_), "");
}

TEST_F(DataIdTest, DataOfAnEarlierVersionGetTheirId) {
    make_dive(*blobs_);
    EXPECT_EQ(data_mismatch(catalog_, *blobs_), "");
    claim_data(catalog_, *blobs_);
    EXPECT_TRUE(has_data_id(catalog_));
    EXPECT_EQ(data_mismatch(catalog_, *blobs_), "");
}

TEST_F(DataIdTest, AnEmptyMountPointDoesNotBecomeTheStoreOfADive) {
    make_dive(*blobs_);
    const auto empty = open("empty");
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { claim_data(catalog_, *empty); }));
    EXPECT_EQ(empty->data_id(), "");
    EXPECT_FALSE(has_data_id(catalog_));
}

TEST_F(DataIdTest, RefusesTheBlobsOfAnotherCatalogAndNone) {
    claim_data(catalog_, *blobs_);
    Catalog other((blobs_folder_ / "other.db").string());
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { claim_data(other, *blobs_); }));
    EXPECT_THAT(data_mismatch(other, *blobs_), HasSubstr("belongs to another catalog"));
    const auto empty = open("empty");
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { claim_data(catalog_, *empty); }));
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { require_same_data(catalog_, *empty); }));
    EXPECT_THAT(data_mismatch(catalog_, *empty), HasSubstr((blobs_folder_ / "empty").string()));
}

// A copy of the catalog's file from before the data got their id.
TEST_F(DataIdTest, AnOlderCatalogThatIsRestoredGoesOnWithItsBlobs) {
    make_dive(*blobs_);
    blobs_->set_data_id("later");
    claim_data(catalog_, *blobs_);
    EXPECT_EQ(data_mismatch(catalog_, *blobs_), "");
    EXPECT_EQ(blobs_->data_id(), "later");
}

TEST_F(DataIdTest, NamesTheIdThatMovedBlobsLack) {
    claim_data(catalog_, *blobs_);
    const std::string id = blobs_->data_id();
    fs::remove(blobs_folder_ / "blobs" / "data-id");
    EXPECT_THAT(data_mismatch(catalog_, *blobs_), HasSubstr("write " + id));
}

// As a disk that was unplugged and mounted again: what is open is the old one.
TEST_F(DataIdTest, NoticesADiskThatWasMountedAgain) {
    claim_data(catalog_, *blobs_);
    fs::rename(blobs_folder_ / "blobs", blobs_folder_ / "away");
    fs::copy(blobs_folder_ / "away", blobs_folder_ / "blobs", fs::copy_options::recursive);
    EXPECT_THAT(data_mismatch(catalog_, *blobs_), HasSubstr("restart"));
    EXPECT_EQ(data_mismatch(catalog_, *open("blobs")), "");
}

TEST_F(DataIdTest, NoticesADiskThatWentAway) {
    claim_data(catalog_, *blobs_);
    fs::rename(blobs_folder_ / "blobs", blobs_folder_ / "away");
    EXPECT_THAT(data_mismatch(catalog_, *blobs_), HasSubstr("may not be mounted"));
    fs::rename(blobs_folder_ / "away", blobs_folder_ / "blobs");
    EXPECT_EQ(data_mismatch(catalog_, *blobs_), "");
}

// A server was killed between its two writes.
TEST_F(DataIdTest, GoesOnAfterAServerThatWasKilledInBetween) {
    catalog_.transaction([](soci::session& session) {
        session << "INSERT INTO data_id (id, confirmed) VALUES ('half', 0)";
    });
    EXPECT_FALSE(has_data_id(catalog_));
    EXPECT_EQ(data_mismatch(catalog_, *blobs_), "");
    blobs_->set_data_id("half");
    EXPECT_EQ(data_mismatch(catalog_, *blobs_), "");
    claim_data(catalog_, *blobs_);
    EXPECT_TRUE(has_data_id(catalog_));
    EXPECT_EQ(blobs_->data_id(), "half");
}

TEST_F(SqliteDataIdTest, OpensOnlyWhatIsThereIfAsked) {
    const auto missing = blobs_folder_ / "missing";
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable,
                            [&] { open_blob_store(missing.string(), Opening::ExistingOnly); }));
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] {
        Catalog{(missing / "catalog.db").string(), Opening::ExistingOnly};
    }));
    EXPECT_FALSE(fs::exists(missing));
    const auto empty = blobs_folder_ / "empty.db";
    std::ofstream{empty};
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] {
        Catalog{empty.string(), Opening::ExistingOnly};
    }));
    EXPECT_EQ(fs::file_size(empty), 0U);
    EXPECT_GT(Catalog(empty.string()).schema_version(), 0);
    EXPECT_GT(Catalog(empty.string(), Opening::ExistingOnly).schema_version(), 0);
    EXPECT_NE(open_blob_store((blobs_folder_ / "blobs").string(), Opening::ExistingOnly), nullptr);
}

// As the database of another program, which is left as it is.
TEST_F(SqliteDataIdTest, MakesNoCatalogOfAnotherDatabase) {
    const std::string file = (blobs_folder_ / "photos.db").string();
    const auto without_versions = [&] {
        Catalog photos(file);
        photos.transaction([](soci::session& session) { session << "DROP TABLE schema_version"; });
    };
    without_versions();
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { Catalog{file, Opening::ExistingOnly}; }));
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { Catalog{file, Opening::ExistingOnly}; }));
}

}  // namespace
}  // namespace divemesh::storage
