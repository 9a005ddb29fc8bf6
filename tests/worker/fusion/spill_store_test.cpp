#include "worker/fusion/spill_store.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>
#include <vector>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::fusion {
namespace {

constexpr std::size_t kRecordBytes = 5000;
constexpr std::int64_t kChunks = SpillStore::kChunkBytes;

std::vector<SpillStore::Handle> fill(SpillStore& store, int num_records) {
    std::vector<SpillStore::Handle> records;
    for (int i = 0; i < num_records; ++i) {
        records.push_back(store.allocate(kRecordBytes));
        std::memset(store.write(records.back()), i & 0xff, kRecordBytes);
        store.trim();
    }
    return records;
}

bool holds(const SpillStore& store, SpillStore::Handle record, int value) {
    const std::byte* bytes = store.read(record);
    return bytes[0] == static_cast<std::byte>(value) &&
           bytes[kRecordBytes - 1] == static_cast<std::byte>(value);
}

TEST(SpillStore, WhatWentToDiskComesBackAsItWas) {
    const TemporaryFolder folder;
    SpillStore store({folder / "", 3 * kChunks});
    const auto records = fill(store, 3000);
    EXPECT_LE(store.memory_bytes(), 4 * kChunks);
    EXPECT_GT(store.size_bytes(), 10 * kChunks);
    for (int i = 0; i < 3000; ++i) {
        ASSERT_TRUE(holds(store, records[i], i & 0xff)) << i;
        store.trim();
        ASSERT_LE(store.memory_bytes(), 3 * kChunks);
    }
}

TEST(SpillStore, ChangesSurviveTheSecondWayToDiskToo) {
    const TemporaryFolder folder;
    SpillStore store({folder / "", 2 * kChunks});
    const auto records = fill(store, 2000);
    for (int i = 0; i < 2000; i += 7) {
        std::memset(store.write(records[i]), 250, kRecordBytes);
        store.trim();
    }
    for (int i = 0; i < 2000; ++i) {
        ASSERT_TRUE(holds(store, records[i], i % 7 == 0 ? 250 : i & 0xff)) << i;
        store.trim();
    }
}

TEST(SpillStore, WithoutAFolderAllStaysInMemory) {
    SpillStore store;
    const auto records = fill(store, 1000);
    EXPECT_EQ(store.memory_bytes(), store.size_bytes());
    EXPECT_TRUE(holds(store, records[0], 0));
}

TEST(SpillStore, SeveralThreadsReadWhatIsOnDisk) {
    const TemporaryFolder folder;
    SpillStore store({folder / "", 2 * kChunks});
    const auto records = fill(store, 2000);
    std::vector<std::size_t> num_right(2, 0);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < 2; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < 2000; ++i)
                num_right[t] += holds(store, records[i], i & 0xff) ? 1 : 0;
        });
    for (auto& thread : threads) thread.join();
    EXPECT_EQ(num_right[0], 2000U);
    EXPECT_EQ(num_right[1], 2000U);
}

TEST(SpillStore, ARecordBeginsWithZerosAndAlignedTo16Bytes) {
    SpillStore store;
    for (int i = 1; i < 100; ++i) {
        const auto record = store.allocate(static_cast<std::size_t>(i));
        EXPECT_EQ(store.read(record)[i - 1], std::byte{0});
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(store.read(record)) % 16, 0U);
    }
}

TEST(SpillStore, AFolderThatIsNotThereIsATypedError) {
    SpillStore store({"/nowhere/at/all", kChunks});
    EXPECT_THROW(fill(store, 1000), Error);
}

}  // namespace
}  // namespace divemesh::fusion
