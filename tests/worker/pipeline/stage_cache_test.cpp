#include "worker/pipeline/stage_cache.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "tests/small_disk.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/base/cache_folder.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

class StageCacheTest : public testing::Test {
protected:
    // Writes the result of a stage: 2,000 bytes in two files, one of them in a folder.
    fs::path make(const std::string& name, char content) {
        fs::create_directories(folder_ / name / "keyframes");
        std::ofstream(folder_ / name / "track.stage") << std::string(1000, content);
        std::ofstream(folder_ / name / "keyframes/1.keyframe") << std::string(1000, content);
        return folder_ / name;
    }
    void store(StageCache& cache, const std::string& key, char content = 'a') {
        cache.store(key, make("from-" + key, content), {"track.stage", "keyframes"});
    }
    bool fetch(StageCache& cache, const std::string& key) {
        const fs::path into = folder_ / ("into-" + std::to_string(++num_fetches_));
        fs::create_directories(into);
        if (cache.fetch(key, into)) {
            EXPECT_EQ(content(into / "track.stage").size(), 1000u);
            EXPECT_EQ(content(into / "keyframes/1.keyframe"), content(into / "track.stage"));
            return true;
        }
        EXPECT_FALSE(fs::exists(into / "track.stage"));
        return false;
    }
    static std::string content(const fs::path& file) {
        std::ifstream stream(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }
    void age(const std::string& key, int hours) {
        fs::last_write_time(cache_folder_ / key / "files.json",
                            fs::file_time_type::clock::now() - std::chrono::hours(hours));
    }

    TemporaryFolder folder_;
    fs::path cache_folder_ = folder_ / "cache";
    StageCache cache_{cache_folder_, 1'000'000};
    int num_fetches_ = 0;
};

TEST_F(StageCacheTest, GivesBackWhatWasStored) {
    EXPECT_FALSE(fetch(cache_, "track-1"));
    store(cache_, "track-1");

    EXPECT_TRUE(fetch(cache_, "track-1"));
    StageCache again(cache_folder_, 1'000'000);
    EXPECT_TRUE(fetch(again, "track-1"));
    EXPECT_FALSE(fetch(cache_, "track-2"));
}

TEST_F(StageCacheTest, WithoutAFolderOrRoomNothingIsKept) {
    StageCache none;
    store(none, "track-1");
    EXPECT_FALSE(fetch(none, "track-1"));
    StageCache no_room(folder_ / "no-room", 0);
    store(no_room, "track-1");
    EXPECT_FALSE(fs::exists(folder_ / "no-room"));
}

TEST_F(StageCacheTest, ADamagedEntryIsMissingAndGone) {
    const auto damage = [&](const std::string& file, const std::string& bytes) {
        store(cache_, "track-1");
        fs::remove(cache_folder_ / "track-1" / file);  // a write would change the link's source
        if (!bytes.empty()) std::ofstream(cache_folder_ / "track-1" / file) << bytes;
        EXPECT_FALSE(fetch(cache_, "track-1")) << file;
        EXPECT_FALSE(fetch(cache_, "track-1")) << file;
        store(cache_, "track-1");
        EXPECT_TRUE(fetch(cache_, "track-1")) << file;
        cache_.drop("track-1");
    };
    damage("track.stage", std::string(1000, 'b'));          // other bytes
    damage("keyframes/1.keyframe", std::string(999, 'a'));  // cut short
    damage("keyframes/1.keyframe", "");                     // lost
    damage("files.json", "[{");                             // the list itself
    damage("files.json", R"([{"name":"x","size_bytes":1}])");
    damage("files.json", R"([{"name":"../../stolen","size_bytes":1,"sha256":""}])");
    damage("files.json", R"([{"name":"/etc/passwd","size_bytes":1,"sha256":""}])");
    EXPECT_FALSE(fs::exists(folder_ / "stolen"));
}

TEST_F(StageCacheTest, WhatWasNotUsedForLongestGoesFirst) {
    StageCache small(cache_folder_, 7000);
    for (const char* key : {"a", "b", "c"}) store(small, key);
    age("a", 1);
    age("b", 3);
    age("c", 2);
    EXPECT_TRUE(fetch(small, "b"));  // makes it the last one used

    store(small, "d");

    EXPECT_FALSE(fetch(small, "c"));
    EXPECT_TRUE(fetch(small, "a"));
    EXPECT_TRUE(fetch(small, "b"));
    EXPECT_TRUE(fetch(small, "d"));
}

TEST_F(StageCacheTest, AnEntryLargerThanTheCacheIsNotKept) {
    StageCache small(cache_folder_, 1500);
    store(small, "a");

    EXPECT_FALSE(fetch(small, "a"));
    EXPECT_TRUE(fs::is_empty(cache_folder_));
}

TEST_F(StageCacheTest, WhatAKilledProcessWasWritingIsNoEntryAndGoesInTheEnd) {
    fs::create_directories(cache_folder_ / "new.abcdef");
    std::ofstream(cache_folder_ / "new.abcdef/track.stage") << "half";
    store(cache_, "a");
    EXPECT_TRUE(fs::exists(cache_folder_ / "new.abcdef"));

    fs::last_write_time(cache_folder_ / "new.abcdef",
                        fs::file_time_type::clock::now() - std::chrono::hours(25));
    store(cache_, "b");

    EXPECT_FALSE(fs::exists(cache_folder_ / "new.abcdef"));
}

constexpr std::int64_t kAllOfTheDisk = std::int64_t{1} << 60;

TEST_F(StageCacheTest, GivesUpForSpaceOnTheDiskWhatNoAttemptUses) {
    store(cache_, "idle");
    fs::remove_all(folder_ / "from-idle");
    store(cache_, "own");  // its attempt still runs, with the files as links
    store(cache_, "fetched");
    fs::remove_all(folder_ / "from-fetched");
    const fs::path attempt = folder_ / "attempt";
    fs::create_directories(attempt);
    ASSERT_TRUE(cache_.fetch("fetched", attempt));

    base::make_room(cache_folder_, kAllOfTheDisk);

    EXPECT_FALSE(fs::exists(cache_folder_ / "idle"));
    EXPECT_TRUE(fetch(cache_, "own"));
    EXPECT_EQ(content(attempt / "track.stage"), std::string(1000, 'a'));
    fs::remove_all(attempt);
    for (int i = 1; i <= num_fetches_; ++i) fs::remove_all(folder_ / ("into-" + std::to_string(i)));
    base::make_room(cache_folder_, kAllOfTheDisk);
    EXPECT_FALSE(fs::exists(cache_folder_ / "fetched"));
    EXPECT_TRUE(fs::exists(cache_folder_ / "own"));
}

TEST_F(StageCacheTest, AnAttemptKeepsWhatItFetchedWhenTheEntryGoes) {
    store(cache_, "a");
    const fs::path attempt = folder_ / "attempt";
    fs::create_directories(attempt);
    ASSERT_TRUE(cache_.fetch("a", attempt));

    base::limit_cache(cache_folder_, 0);

    EXPECT_FALSE(fs::exists(cache_folder_ / "a"));
    EXPECT_EQ(content(attempt / "track.stage"), std::string(1000, 'a'));
    EXPECT_EQ(content(attempt / "keyframes/1.keyframe"), std::string(1000, 'a'));
}

TEST_F(StageCacheTest, KeepsAllOnADiskWithRoom) {
    store(cache_, "a");
    fs::remove_all(folder_ / "from-a");

    base::make_room(cache_folder_, 1);
    base::make_room(folder_ / "no-cache", kAllOfTheDisk);

    EXPECT_TRUE(fetch(cache_, "a"));
    EXPECT_FALSE(fs::exists(folder_ / "no-cache"));
    EXPECT_EQ(base::reachable_free_bytes(folder_ / "no-cache"), 0);
}

TEST(FullDiskTest, TheCacheGivesUpNoMoreThanIsWanted) {
    const SmallDisk disk(64);
    if (!disk.mounted()) GTEST_SKIP() << "needs the right to mount a tmpfs";
    const auto make_entry = [&](const std::string& key, int age_h) {
        disk.write(disk.path() / key / "track.stage", 10);
        std::ofstream(disk.path() / key / base::kCacheListName) << "[]";
        fs::last_write_time(disk.path() / key / base::kCacheListName,
                            fs::file_time_type::clock::now() - std::chrono::hours(age_h));
    };
    make_entry("b", 3);
    make_entry("a", 1);
    make_entry("c", 2);
    const std::int64_t free_bytes = disk.free_bytes();
    EXPECT_NEAR(static_cast<double>(base::reachable_free_bytes(disk.path()) - free_bytes),
                30 << 20,
                64 << 10);

    base::make_room(disk.path(), free_bytes + (15 << 20));

    EXPECT_FALSE(fs::exists(disk.path() / "b"));
    EXPECT_FALSE(fs::exists(disk.path() / "c"));
    EXPECT_TRUE(fs::exists(disk.path() / "a"));
    disk.fill();  // to remove an entry needs no space
    base::make_room(disk.path(), 5 << 20);
    EXPECT_FALSE(fs::exists(disk.path() / "a"));
}

// Four threads use a cache that holds two entries of five at a time: each fetch gets a whole entry
// or fails.
TEST_F(StageCacheTest, ManyAtOnceSeeWholeEntriesAlone) {
    std::vector<std::thread> threads;
    // Returns whether the entry was there; it is whole then.
    const auto fetched = [](StageCache& cache, char letter, const fs::path& into) {
        fs::create_directories(into / "keyframes");
        if (!cache.fetch(std::string(1, letter), into)) return false;
        EXPECT_EQ(content(into / "track.stage"), std::string(1000, letter));
        EXPECT_EQ(content(into / "keyframes/1.keyframe"), std::string(1000, letter));
        return true;
    };
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            StageCache cache(cache_folder_, 4500);
            const fs::path own = folder_ / ("thread-" + std::to_string(t));
            for (int i = 0; i < 15; ++i) {
                const auto letter = static_cast<char>('a' + (i + t) % 5);
                const fs::path into = own / std::to_string(i);
                if (fetched(cache, letter, into)) continue;
                std::ofstream(into / "track.stage") << std::string(1000, letter);
                std::ofstream(into / "keyframes/1.keyframe") << std::string(1000, letter);
                cache.store(std::string(1, letter), into, {"track.stage", "keyframes"});
            }
        });
    for (std::thread& thread : threads) thread.join();

    StageCache cache(cache_folder_, 4500);
    int num_left = 0;
    for (const char letter : {'a', 'b', 'c', 'd', 'e'})
        num_left += fetched(cache, letter, folder_ / std::string(1, letter)) ? 1 : 0;
    EXPECT_GT(num_left, 0) << "the last one stored is not evicted";
    std::size_t num_entries = 0;
    for (const auto& entry : fs::directory_iterator(cache_folder_))
        num_entries += entry.is_directory();
    EXPECT_LE(num_entries, 2u);
}

}  // namespace
}  // namespace divemesh::pipeline
