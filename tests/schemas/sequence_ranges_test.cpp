#include "schemas/sequence_ranges.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>

namespace divemesh {
namespace {

// Returns the length of the contiguous run from the start, from a set of the same numbers.
std::int64_t contiguous(const std::set<std::int64_t>& numbers) {
    std::int64_t next = 0;
    while (numbers.contains(next)) ++next;
    return next - 1;
}

TEST(SequenceRangesTest, EqualsASetInAnyOrderAndWithRepeats) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        std::mt19937 random(seed);
        SequenceRanges ranges;
        std::set<std::int64_t> numbers;
        for (int i = 0; i < 300; ++i) {
            const auto number = static_cast<std::int64_t>(random() % 200);
            EXPECT_EQ(ranges.add(number), numbers.insert(number).second);
            ASSERT_EQ(ranges.acknowledged(), contiguous(numbers));
            ASSERT_EQ(ranges.newest(), *numbers.rbegin());
            std::int64_t num_missing = 0;
            for (const auto& [first, last] : ranges.gaps()) {
                num_missing += last - first + 1;
                for (std::int64_t missing = first; missing <= last; ++missing)
                    ASSERT_FALSE(numbers.contains(missing));
            }
            ASSERT_EQ(num_missing,
                      *numbers.rbegin() + 1 - static_cast<std::int64_t>(numbers.size()));
        }
        EXPECT_EQ(ranges.num_lost(), 0);
    }
}

TEST(SequenceRangesTest, DoesNotWaitForMessagesThatTheSenderLost) {
    SequenceRanges ranges;
    for (const std::int64_t number : {0, 1, 5, 6, 9}) ranges.add(number);
    ranges.give_up({2, 7});  // 5 and 6 of them had arrived
    EXPECT_EQ(ranges.num_lost(), 4);
    EXPECT_EQ(ranges.acknowledged(), 7);
    ranges.give_up({8, 12});
    EXPECT_EQ(ranges.num_lost(), 8);
    EXPECT_EQ(ranges.acknowledged(), 12);
    EXPECT_TRUE(ranges.add(11)) << "it came after all: nothing that comes is thrown away";
    EXPECT_FALSE(ranges.add(11));
    EXPECT_EQ(ranges.num_lost(), 7);
    EXPECT_EQ(ranges.acknowledged(), 12);
}

TEST(SequenceRangesTest, StaysBoundedIfEveryOtherMessageIsMissing) {
    SequenceRanges ranges;
    for (std::int64_t number = 0; number < 100'000; number += 2) ranges.add(number);
    EXPECT_LE(ranges.gaps().size(), SequenceRanges::kMaxRanges);
    EXPECT_EQ(ranges.newest(), 99'998);
    EXPECT_EQ(ranges.num_lost(), 49'999 - static_cast<std::int64_t>(ranges.gaps().size()));
    EXPECT_GT(ranges.acknowledged(), 99'000);
    EXPECT_LT(nlohmann::json(ranges).dump().size(), 16'000U);
    EXPECT_TRUE(ranges.add(99'001));
    EXPECT_FALSE(ranges.add(1)) << "too long ago";
    const std::int64_t acknowledged = ranges.acknowledged();
    EXPECT_TRUE(ranges.add(acknowledged - 1)) << "given up for want of room";
    EXPECT_FALSE(ranges.add(acknowledged - 1));
    EXPECT_EQ(ranges.acknowledged(), acknowledged);
}

TEST(SequenceRangesTest, IsTheSameAfterItWasStored) {
    SequenceRanges ranges;
    for (const std::int64_t number : {0, 3, 4}) ranges.add(number);
    ranges.give_up({1, 1});
    auto stored = nlohmann::json::parse(nlohmann::json(ranges).dump()).get<SequenceRanges>();
    EXPECT_EQ(stored.num_lost(), 1);
    EXPECT_EQ(stored.acknowledged(), 1);
    EXPECT_FALSE(stored.add(4));
    EXPECT_TRUE(stored.add(2));
    EXPECT_EQ(stored.acknowledged(), 4);
}

}  // namespace
}  // namespace divemesh
