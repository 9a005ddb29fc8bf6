#include "worker/loops/consistent_loops.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/synthetic/pose_near.hpp"
#include "worker/loops/pose_graph.hpp"
#include "worker/loops/strongest_loops.hpp"

namespace divemesh::loops {
namespace {

constexpr std::size_t kLap = 60;

// A lap and a sixth around a circle of 3 m radius. In the estimate, each step rotates too far by
// `yaw_error`.
struct Laps {
    explicit Laps(double yaw_error, std::size_t blind_at = 0) {
        Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
        for (std::size_t k = 0; k < kLap + 10; ++k) {
            const double angle =
                2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(kLap);
            Eigen::Isometry3d T_true = Eigen::Isometry3d::Identity();
            T_true.translation() << 3.0 * std::cos(angle), 3.0 * std::sin(angle), 0.0;
            T_true.rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
            if (k == 0)
                T_world_cam = T_true;
            else
                T_world_cam = T_world_cam * (truth.back().inverse() * T_true) *
                              Eigen::AngleAxisd(yaw_error, Eigen::Vector3d::UnitZ());
            truth.push_back(T_true);
            keyframes.push_back(
                {static_cast<int>(k), static_cast<std::int64_t>(k) * 1'000'000'000, T_world_cam});
        }
        for (std::size_t k = 0; k + 1 < keyframes.size(); ++k) {
            if (k + 1 == blind_at) continue;
            for (int i = 0; i < 10; ++i) {
                types::Landmark landmark;
                landmark.p_world = keyframes[k].T_world_cam * Eigen::Vector3d(0.1 * i, 0.0, 2.0);
                landmark.observations = {{static_cast<std::int32_t>(k)},
                                         {static_cast<std::int32_t>(k + 1)}};
                landmarks.push_back(landmark);
            }
        }
    }

    Loop loop(std::size_t from, std::size_t to) const {
        Loop loop;
        loop.from = from;
        loop.to = to;
        loop.T_from_to = truth[from].inverse() * truth[to];
        loop.sigma_m = 0.01;
        return loop;
    }
    // Returns a loop that claims that both keyframes have the same pose.
    static Loop false_loop(std::size_t from, std::size_t to) {
        Loop loop;
        loop.from = from;
        loop.to = to;
        loop.sigma_m = 0.01;
        return loop;
    }

    std::vector<Eigen::Isometry3d> truth;
    std::vector<types::Keyframe> keyframes;
    std::vector<types::Landmark> landmarks;
};

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

TEST(AdjustPosesTest, AnEvenYawErrorGoesAwayAlongTheWholeLap) {
    Laps laps(0.004);  // 14 degrees over the lap
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    const std::vector<Loop> loops = {laps.loop(0, 60), laps.loop(3, 63), laps.loop(6, 66)};
    const double before_m =
        (laps.keyframes[45].T_world_cam.translation() - laps.truth[45].translation()).norm();
    ASSERT_GT(before_m, 0.2);

    optimise_pose_graph(loops, drift, laps.keyframes, laps.landmarks);

    for (std::size_t k = 0; k < laps.keyframes.size(); ++k)
        EXPECT_THAT(laps.keyframes[k].T_world_cam,
                    synthetic::IsPoseWithin(laps.truth[k], 2.0, 0.06))
            << "keyframe " << k;
}

TEST(AdjustPosesTest, LandmarksGoWithTheirKeyframes) {
    Laps laps(0.004);
    const DriftModel drift(laps.keyframes, laps.landmarks, nullptr);
    optimise_pose_graph({laps.loop(0, 60)}, drift, laps.keyframes, laps.landmarks);
    ASSERT_FALSE(laps.landmarks.empty());
    for (const types::Landmark& landmark : laps.landmarks) {
        const auto anchor = static_cast<std::size_t>(landmark.observations.front().keyframe);
        const Eigen::Vector3d p_cam =
            laps.keyframes[anchor].T_world_cam.inverse() * landmark.p_world;
        EXPECT_NEAR(p_cam.z(), 2.0, 1e-9);
        EXPECT_NEAR(p_cam.y(), 0.0, 1e-9);
    }
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
