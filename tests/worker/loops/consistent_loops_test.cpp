#include "worker/loops/consistent_loops.hpp"

#include <gtest/gtest.h>

#include "tests/worker/loops/laps.hpp"
#include "worker/loops/strongest_loops.hpp"

namespace divemesh::loops {
namespace {

TEST(ConsistentLoopsTest, TrueLoopsStayAndFalseOnesGo) {
    const Laps laps(0.001);
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    const std::vector<Loop> loops = {laps.loop(0, 60),
                                     laps.loop(2, 61),
                                     Laps::false_loop(10, 40),
                                     laps.loop(4, 63),
                                     Laps::false_loop(20, 64),
                                     Laps::false_loop(11, 46)};
    EXPECT_EQ(consistent_loops(loops, laps.keyframes, drift), (std::vector<std::size_t>{0, 1, 3}));
}

TEST(ConsistentLoopsTest, OneLoopAloneIsNotBelieved) {
    const Laps laps(0.001);
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    EXPECT_TRUE(consistent_loops({laps.loop(0, 60)}, laps.keyframes, drift).empty());
    EXPECT_TRUE(consistent_loops({}, laps.keyframes, drift).empty());
}

TEST(ConsistentLoopsTest, ThreeLoopsJoinSegmentsButTwoDoNot) {
    const Laps laps(0.001, 30);
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    ASSERT_NE(drift.segment(29), drift.segment(30));
    const std::vector<Loop> two = {laps.loop(0, 60), laps.loop(1, 62)};
    EXPECT_TRUE(consistent_loops(two, laps.keyframes, drift).empty());
    const std::vector<Loop> three = {laps.loop(0, 60), laps.loop(1, 62), laps.loop(3, 64)};
    EXPECT_EQ(consistent_loops(three, laps.keyframes, drift).size(), 3U);
}

TEST(StrongestLoopsTest, KeepsTheLoopWithTheMostReobservationsOfEachRun) {
    const Laps laps(0.0);
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    std::vector<Loop> loops;
    for (std::size_t i = 0; i < 10; ++i) {
        loops.push_back(laps.loop(i, kLap + i));
        loops.back().reobservations.resize(i % 5 == 2 ? 40 : 30);
    }
    EXPECT_EQ(strongest_loops(loops, drift, 2), (std::vector<std::size_t>{2, 7}));
    EXPECT_EQ(strongest_loops(loops, drift, 10).size(), 10U);
    EXPECT_TRUE(strongest_loops({}, drift, 2).empty());
}

TEST(StrongestLoopsTest, KeepsEveryLoopThatJoinsOtherSegments) {
    const Laps laps(0.0, kLap + 8);
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    std::vector<Loop> loops;
    for (std::size_t i = 0; i < 10; ++i) loops.push_back(laps.loop(i, kLap + i));
    EXPECT_EQ(strongest_loops(loops, drift, 1), (std::vector<std::size_t>{0, 8}));
}

}  // namespace
}  // namespace divemesh::loops
