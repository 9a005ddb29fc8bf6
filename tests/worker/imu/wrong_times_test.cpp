#include "worker/imu/wrong_times.hpp"

#include <gtest/gtest.h>

namespace divemesh::imu {
namespace {

constexpr std::int64_t kSpan_ns = 300'000'000;

// Returns differences of 30 s that drift slowly, with the given ones far off.
std::vector<Difference> differences(std::size_t from, std::size_t to) {
    std::vector<Difference> result;
    for (std::size_t i = 0; i < 100; ++i) {
        const auto begin_ns = static_cast<std::int64_t>(i) * kSpan_ns;
        const double rate = 0.01 * static_cast<double>(i % 3) + 1e-4 * static_cast<double>(i);
        result.push_back({{begin_ns, begin_ns + kSpan_ns}, {rate, 0.0, 0.0}});
        if (from <= i && i < to) result.back().value.y() += 0.5;
    }
    return result;
}

TEST(WrongTimesTest, DriftAndNoiseAreRight) {
    EXPECT_TRUE(wrong_times(differences(0, 0), 0.08).empty());
}

TEST(WrongTimesTest, FindsSecondsWithAMargin) {
    const auto times = wrong_times(differences(40, 50), 0.08);
    ASSERT_EQ(times.size(), 1U);
    EXPECT_EQ(times[0].from_ns, 40 * kSpan_ns - 1'000'000'000);
    EXPECT_EQ(times[0].to_ns, 50 * kSpan_ns + 1'000'000'000);
}

TEST(WrongTimesTest, ASecondMayBeTheImages) {
    EXPECT_TRUE(wrong_times(differences(40, 43), 0.08).empty());
}

TEST(WrongTimesTest, SecondsWithoutImagesAmongWrongOnesAreWrong) {
    std::vector<Difference> some = differences(40, 60);
    some.erase(some.begin() + 44, some.begin() + 55);
    const auto times = wrong_times(some, 0.08);
    ASSERT_EQ(times.size(), 1U);
    EXPECT_EQ(times[0].from_ns, 40 * kSpan_ns - 1'000'000'000);
    EXPECT_EQ(times[0].to_ns, 60 * kSpan_ns + 1'000'000'000);
}

TEST(WrongTimesTest, NothingWasMeasured) { EXPECT_TRUE(wrong_times({}, 0.08).empty()); }

}  // namespace
}  // namespace divemesh::imu
