#include "worker/simulator/path_time.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh::simulator {
namespace {

constexpr double kStep_s = 1e-4;

PathTime resting(const std::vector<Rest>& rests) { return PathTime(rests); }

TEST(PathTimeTest, WithoutRestsItIsTheTimeOfTheDive) {
    const PathTime path_time;
    for (const double t_s : {-0.5, 0.0, 3.25}) {
        EXPECT_EQ(path_time.at(t_s).value, t_s);
        EXPECT_EQ(path_time.at(t_s).first, 1.0);
        EXPECT_EQ(path_time.at(t_s).second, 0.0);
    }
    EXPECT_EQ(path_time.end_of(7.0), 7.0);
}

TEST(PathTimeTest, RestsWhereAndAsLongAsAskedAndThenGoesOn) {
    const PathTime path_time = resting({{4.0, 3.0}});
    const double rest_begins_s = 4.0 + 0.5 * PathTime::kRamp_s;
    for (const double t_s : {rest_begins_s, rest_begins_s + 1.5, rest_begins_s + 3.0}) {
        EXPECT_NEAR(path_time.at(t_s).value, 4.0, 1e-12);
        EXPECT_NEAR(path_time.at(t_s).first, 0.0, 1e-12);
    }
    EXPECT_EQ(path_time.at(3.0).value, 3.0);
    EXPECT_NEAR(path_time.at(path_time.end_of(9.0)).value, 9.0, 1e-12);
    EXPECT_NEAR(path_time.end_of(9.0), 9.0 + 3.0 + PathTime::kRamp_s, 1e-12);
}

TEST(PathTimeTest, RestAtTheStartBeginsAtRestBeforeTheFirstFrameToo) {
    const PathTime path_time = resting({{0.0, 2.0}});
    for (const double t_s : {-0.5, 0.0, 2.0}) {
        EXPECT_EQ(path_time.at(t_s).value, 0.0);
        EXPECT_EQ(path_time.at(t_s).first, 0.0);
    }
    EXPECT_GT(path_time.at(2.1).value, 0.0);
}

TEST(PathTimeTest, RestAtTheEndIsTheEnd) {
    const PathTime path_time = resting({{6.0, 2.0}});
    const double end_s = path_time.end_of(6.0);
    EXPECT_NEAR(end_s, 6.0 + 0.5 * PathTime::kRamp_s + 2.0, 1e-12);
    EXPECT_NEAR(path_time.at(end_s).value, 6.0, 1e-12);
}

TEST(PathTimeTest, DerivativesAreThoseOfItsValueAlsoWhileItSlowsDown) {
    const PathTime path_time = resting({{0.0, 0.7}, {2.0, 1.0}});
    for (double t_s = 0.0; t_s < 5.0; t_s += 0.037) {
        const Jet before = path_time.at(t_s - kStep_s);
        const Jet now = path_time.at(t_s);
        const Jet after = path_time.at(t_s + kStep_s);
        EXPECT_NEAR((after.value - before.value) / (2.0 * kStep_s), now.first, 1e-5);
        EXPECT_NEAR((after.first - before.first) / (2.0 * kStep_s), now.second, 2e-3);
    }
}

TEST(PathTimeTest, RestsTooCloseToEachOtherAreRefused) {
    EXPECT_THROW(resting({{2.0, 1.0}, {2.1, 1.0}}), Error);
}

}  // namespace
}  // namespace divemesh::simulator
