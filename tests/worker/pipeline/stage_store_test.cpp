#include "worker/pipeline/stage_store.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <memory>

#include "storage/blob_store.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/pipeline/blob_stage_store.hpp"
#include "worker/pipeline/stage_cache.hpp"

// What every store of stages promises, tested on each implementation.
namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& file, const std::string& bytes) {
    fs::create_directories(file.parent_path());
    fs::remove(file);  // replaces the file and never changes it in place
    std::ofstream(file, std::ios::binary) << bytes;
}

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::size_t num_files(const fs::path& folder) {
    std::size_t num = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        num += entry.is_regular_file();
    return num;
}

// A store in a folder on this machine.
struct FolderStore {
    explicit FolderStore(const fs::path& at) : folder(at) {}
    std::unique_ptr<StageStore> open() const {
        return std::make_unique<StageCache>(folder, 1'000'000);
    }
    void lose(const std::string& key, const std::string& file) { fs::remove(folder / key / file); }
    void change(const std::string& key, const std::string& file, const std::string& bytes) {
        write(folder / key / file, bytes);
    }
    fs::path folder;
};

// A store of blobs, which neither links nor has a folder of its own.
struct BlobsStore {
    explicit BlobsStore(const fs::path& at)
        : folder(at), blobs(storage::open_blob_store(at.string())) {}
    std::unique_ptr<StageStore> open() const { return std::make_unique<BlobStageStore>(*blobs); }
    void lose(const std::string& key, const std::string& file) {
        blobs->remove(BlobStageStore::blob_of(key, file));
    }
    void change(const std::string& key, const std::string& file, const std::string& bytes) {
        lose(key, file);
        write(folder / "changed", bytes);
        blobs->put_file(BlobStageStore::blob_of(key, file), folder / "changed");
    }
    fs::path folder;
    std::unique_ptr<storage::BlobStore> blobs;
};

template <typename Implementation>
class StageStoreTest : public testing::Test {
protected:
    // Writes the result of a stage, a file and two files in folders; `letter` distinguishes
    // entries.
    fs::path stage_result(char letter) {
        const fs::path scratch = folder_ / ("scratch-" + std::string(1, letter));
        write(scratch / "track.stage", std::string(1000, letter));
        write(scratch / "keyframes/000001.keyframe", std::string(10, letter));
        write(scratch / "keyframes/deeper/000002.keyframe", "");
        write(scratch / "other.stage", "of another stage");
        return scratch;
    }
    void keep(const std::string& key, char letter) {
        store_->store(key, stage_result(letter), {"track.stage", "keyframes"});
    }
    fs::path empty_folder() {
        fs::path folder = folder_ / ("into-" + std::to_string(++num_folders_));
        fs::create_directories(folder);
        return folder;
    }
    void expect_entry(StageStore& store, const std::string& key, char letter) {
        const fs::path into = empty_folder();
        ASSERT_TRUE(store.fetch(key, into)) << key;
        EXPECT_EQ(content(into / "track.stage"), std::string(1000, letter));
        EXPECT_EQ(content(into / "keyframes/000001.keyframe"), std::string(10, letter));
        EXPECT_TRUE(fs::is_regular_file(into / "keyframes/deeper/000002.keyframe"));
        EXPECT_EQ(num_files(into), 3U);
    }
    void expect_missing(const std::string& key) {
        const fs::path into = empty_folder();
        EXPECT_FALSE(store_->fetch(key, into)) << key;
        EXPECT_EQ(num_files(into), 0U);
    }

    TemporaryFolder folder_;
    Implementation implementation_{folder_ / "store"};
    std::unique_ptr<StageStore> store_ = implementation_.open();
    int num_folders_ = 0;
};

using Implementations = testing::Types<FolderStore, BlobsStore>;
TYPED_TEST_SUITE(StageStoreTest, Implementations);

TYPED_TEST(StageStoreTest, GivesBackWhatWasStoredAndNothingElse) {
    this->expect_missing("track-a");
    this->keep("track-a", 'a');

    this->expect_entry(*this->store_, "track-a", 'a');
    this->expect_entry(*this->store_, "track-a", 'a');
    this->expect_missing("track-b");
}

TYPED_TEST(StageStoreTest, KeepsEntriesWithTheSameFileNamesApart) {
    this->keep("track-a", 'a');
    this->keep("track-b", 'b');

    this->expect_entry(*this->store_, "track-a", 'a');
    this->expect_entry(*this->store_, "track-b", 'b');
}

TYPED_TEST(StageStoreTest, AnotherProcessFindsTheEntry) {
    this->keep("track-a", 'a');

    this->expect_entry(*this->implementation_.open(), "track-a", 'a');
}

TYPED_TEST(StageStoreTest, TheEntryOutlivesTheFolderThatItCameFrom) {
    this->keep("track-a", 'a');
    fs::remove_all(this->folder_ / "scratch-a");

    this->expect_entry(*this->store_, "track-a", 'a');
}

TYPED_TEST(StageStoreTest, WhatReplacesAFetchedFileDoesNotReachTheEntry) {
    this->keep("track-a", 'a');
    const fs::path into = this->empty_folder();
    ASSERT_TRUE(this->store_->fetch("track-a", into));
    write(into / "track.stage", "made anew");

    this->expect_entry(*this->store_, "track-a", 'a');
}

TYPED_TEST(StageStoreTest, FetchedFilesReplaceThoseThatAreThere) {
    this->keep("track-a", 'a');
    const fs::path into = this->stage_result('b');
    ASSERT_TRUE(this->store_->fetch("track-a", into));

    EXPECT_EQ(content(into / "track.stage"), std::string(1000, 'a'));
    EXPECT_EQ(content(into / "other.stage"), "of another stage");
}

TYPED_TEST(StageStoreTest, AnEntryThatIsThereStays) {
    this->keep("track-a", 'a');
    this->store_->store("track-a", this->stage_result('b'), {"track.stage", "keyframes"});

    this->expect_entry(*this->store_, "track-a", 'a');
}

TYPED_TEST(StageStoreTest, WhatIsDroppedIsGoneAndCanBeStoredAgain) {
    this->keep("track-a", 'a');
    this->keep("track-b", 'b');
    this->store_->drop("track-a");
    this->store_->drop("never-there");

    this->expect_missing("track-a");
    this->expect_entry(*this->store_, "track-b", 'b');
    this->keep("track-a", 'c');
    this->expect_entry(*this->store_, "track-a", 'c');
}

TYPED_TEST(StageStoreTest, ADamagedEntryIsMissingAndMadeAgain) {
    const auto damaged = [&](const auto& damage) {
        this->keep("track-a", 'a');
        damage();
        this->expect_missing("track-a");
        this->keep("track-a", 'a');
        this->expect_entry(*this->store_, "track-a", 'a');
        this->store_->drop("track-a");
    };
    auto& implementation = this->implementation_;
    damaged([&] { implementation.lose("track-a", "track.stage"); });
    damaged([&] { implementation.lose("track-a", "keyframes/deeper/000002.keyframe"); });
    damaged([&] { implementation.change("track-a", "track.stage", std::string(1000, 'b')); });
    damaged([&] { implementation.change("track-a", "keyframes/000001.keyframe", "short"); });
}

TYPED_TEST(StageStoreTest, AnEntryWithoutOneOfItsFilesIsNotKept) {
    this->store_->store("track-a", this->stage_result('a'), {"track.stage", "not-there"});

    this->expect_missing("track-a");
}

}  // namespace
}  // namespace divemesh::pipeline
