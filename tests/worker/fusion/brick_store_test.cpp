#include "worker/fusion/brick_store.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <vector>

#include "tests/temporary_folder.hpp"

namespace divemesh::fusion {
namespace {

// A store and the owners of its bricks.
struct Owned {
    explicit Owned(const SpillSettings& spill = {})
        : store(spill,
                [this](std::uint32_t owner, BrickStore::Handle brick) { bricks[owner] = brick; }) {}

    void make() {
        const auto owner = static_cast<std::uint32_t>(bricks.size());
        bricks.push_back(0);
        bricks[owner] = store.make(owner);
    }
    double bytes_per_leaf() const {
        return static_cast<double>(store.size_bytes()) / static_cast<double>(store.num_leaves());
    }

    std::vector<BrickStore::Handle> bricks;
    BrickStore store;
};

using Leaves = std::map<int, std::uint32_t>;  // colour by place

Leaves leaves_of(const Owned& owned, std::size_t owner) {
    Leaves leaves;
    int last = -1;
    owned.store.for_each(owned.bricks[owner], [&](int place, const PointLeaf& leaf) {
        EXPECT_GT(place, last);
        last = place;
        leaves[place] = leaf.color;
    });
    return leaves;
}

// Adds leaves at random to bricks in turn, until each brick has its number of leaves.
void fill(Owned& owned,
          std::size_t num_bricks,
          int min_leaves,
          int max_leaves,
          std::vector<Leaves>& expected) {
    std::mt19937 random(7);
    std::vector<std::size_t> growing;
    std::vector<std::size_t> wanted;
    for (std::size_t i = 0; i < num_bricks; ++i) {
        owned.make();
        growing.push_back(i);
        wanted.push_back(min_leaves + random() % (max_leaves - min_leaves + 1));
    }
    expected.resize(num_bricks);
    while (!growing.empty()) {
        const std::size_t at = random() % growing.size();
        const std::size_t owner = growing[at];
        const int place = static_cast<int>(random() % kBlockSamples);
        const auto color = static_cast<std::uint32_t>(random());
        owned.store.leaf(owned.bricks[owner], place).color = expected[owner][place] = color;
        if (expected[owner].size() < wanted[owner]) continue;
        growing[at] = growing.back();
        growing.pop_back();
    }
}

TEST(BrickStore, HasEveryLeafWhereItWasPutWhileBricksGrowAndMove) {
    Owned owned;
    std::vector<Leaves> expected;
    fill(owned, 300, 1, kBlockSamples, expected);
    std::int64_t num = 0;
    for (std::size_t owner = 0; owner < expected.size(); ++owner) {
        EXPECT_EQ(leaves_of(owned, owner), expected[owner]) << owner;
        num += static_cast<std::int64_t>(expected[owner].size());
        for (int place = 0; place < kBlockSamples; ++place) {
            const PointLeaf* leaf = owned.store.find(owned.bricks[owner], place);
            ASSERT_EQ(leaf != nullptr, expected[owner].contains(place)) << owner << ' ' << place;
            if (leaf != nullptr) {
                EXPECT_EQ(leaf->color, expected[owner].at(place));
            }
        }
    }
    EXPECT_EQ(owned.store.num_leaves(), num);
}

TEST(BrickStore, ANewLeafIsEmptyAlsoWhereAnotherWas) {
    Owned owned;
    std::vector<Leaves> expected;
    fill(owned, 2000, 1, 20, expected);
    owned.make();
    for (int place = 0; place < 12; ++place) {
        const PointLeaf& leaf = owned.store.leaf(owned.bricks.back(), place);
        EXPECT_EQ(leaf.weight, 0);
        EXPECT_EQ(leaf.color, 0U);
    }
    EXPECT_EQ(leaves_of(owned, owned.bricks.size() - 1).size(), 12U);
}

TEST(BrickStore, RecordsFitBricksOfTenLeavesOrMoreInWhateverOrderTheyGrow) {
    for (const int max_leaves : {16, 25, 60, 120, 250}) {
        Owned owned;
        std::vector<Leaves> expected;
        fill(owned,
             static_cast<std::size_t>(600'000 / max_leaves),
             max_leaves / 2,
             max_leaves,
             expected);
        RecordProperty("bytes_per_leaf_" + std::to_string(max_leaves),
                       std::to_string(owned.bytes_per_leaf()));
        // 20 bytes for leaf, place and half a handle, then half an unused leaf and a header.
        EXPECT_LT(owned.bytes_per_leaf(), 24.0) << max_leaves;
    }
}

TEST(BrickStore, IsTheSameWhenMostOfItIsOnDisk) {
    const TemporaryFolder folder;
    Owned owned({folder / "", std::int64_t{1} << 20});
    std::mt19937 random(3);
    std::vector<Leaves> expected(20000);
    for (std::size_t owner = 0; owner < expected.size(); ++owner) owned.make();
    for (std::size_t round = 0; round < 40; ++round) {
        for (std::size_t i = 0; i < expected.size() / 4; ++i) {
            const std::size_t owner = (round * 997 + i) % expected.size();
            const int place = static_cast<int>(random() % kBlockSamples);
            owned.store.leaf(owned.bricks[owner], place).color = expected[owner][place] =
                static_cast<std::uint32_t>(random());
        }
        owned.store.trim();
    }
    EXPECT_LT(owned.store.memory_bytes(), owned.store.size_bytes() / 2);
    for (std::size_t owner = 0; owner < expected.size(); ++owner)
        EXPECT_EQ(leaves_of(owned, owner), expected[owner]) << owner;
}

}  // namespace
}  // namespace divemesh::fusion
