#include "worker/base/radix_sort.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

namespace divemesh::base {
namespace {

using Pair = std::pair<std::uint64_t, int>;  // key and place before

void expect_as_stable_sort(const std::vector<std::uint64_t>& keys) {
    std::vector<Pair> values;
    for (const std::uint64_t key : keys) values.emplace_back(key, static_cast<int>(values.size()));
    std::vector<Pair> truth = values;
    const auto key_of = [](const Pair& value) { return value.first; };
    std::stable_sort(truth.begin(), truth.end(), [&](const Pair& a, const Pair& b) {
        return key_of(a) < key_of(b);
    });

    int num_passes = 0;
    radix_sort(values, key_of, [&] { ++num_passes; });

    EXPECT_EQ(values, truth);
    EXPECT_LE(num_passes, 8);
}

TEST(RadixSortTest, SortsAsAStableSortDoes) {
    std::mt19937_64 random(7);
    for (const std::uint64_t mask : {~0ULL, 0xFFULL, 0xF00000000000000FULL, 3ULL}) {
        std::vector<std::uint64_t> keys(5000);
        for (std::uint64_t& key : keys) key = random() & mask;
        expect_as_stable_sort(keys);
    }
}

TEST(RadixSortTest, NoneAndOneAndEqualKeysAreSorted) {
    expect_as_stable_sort({});
    expect_as_stable_sort({~0ULL});
    expect_as_stable_sort({5, 5, 5});
}

}  // namespace
}  // namespace divemesh::base
