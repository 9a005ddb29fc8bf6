#include "worker/compare/change_map.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/rough_ground.hpp"

namespace divemesh::compare {
namespace {

using synthetic::ground_mesh;

// Level ground. In the later dive a plate 0.4 m wide lies on its middle.
class ChangeMapTest : public testing::Test {
protected:
    static constexpr double kReach_m = 0.5;
    static constexpr M3c2Distance kUnknown{};
    static constexpr M3c2Distance kRaised{0.05F, 0.01F};
    static constexpr M3c2Distance kWithinItsLevel{0.05F, 0.06F};

    // Returns the state of the plate's middle, where all vertices of a dive have this distance.
    static CellState state(double thickness_m, const M3c2Distance& of_a, const M3c2Distance& of_b) {
        const types::Mesh a =
            ground_mesh([](double, double) { return 0.0; }, 1.0, 1.0, 0.02, 0.001, 1);
        const types::Mesh b = ground_mesh(
            [&](double x, double y) {
                return std::max(std::abs(x), std::abs(y)) < 0.2 ? thickness_m : 0.0;
            },
            1.0,
            1.0,
            0.02,
            0.001,
            2);
        const std::vector<M3c2Distance> distances_a(a.vertices.size(), of_a);
        const std::vector<M3c2Distance> distances_b(b.vertices.size(), of_b);
        const std::optional<Views> unchecked;
        const ChangeMap map = map_changes({a, distances_a, unchecked},
                                          {b, distances_b, unchecked},
                                          CoRegistration{},
                                          {.grid = {0.02, {-1.0, 1.0}, 100, 100},
                                           .scale_m = 0.08,
                                           .reach_m = kReach_m,
                                           .num_threads = 1});
        EXPECT_NEAR(static_cast<double>(map.change_m.at<float>(50, 50)), thickness_m, 0.005);
        return map.at(50, 50);
    }
};

TEST_F(ChangeMapTest, AChangeThatNoDistanceConfirmsIsNotDetected) {
    EXPECT_EQ(state(0.05, kUnknown, kUnknown), CellState::Stable);
}

TEST_F(ChangeMapTest, ADistanceOfEitherSurfaceConfirmsAChange) {
    EXPECT_EQ(state(0.05, kRaised, kUnknown), CellState::Grown);
    EXPECT_EQ(state(0.05, kUnknown, kRaised), CellState::Grown);
    EXPECT_EQ(state(0.05, kRaised, kRaised), CellState::Grown);
}

TEST_F(ChangeMapTest, ADistanceThatIsNotSignificantContradictsAChange) {
    EXPECT_EQ(state(0.05, kWithinItsLevel, kRaised), CellState::Stable);
    EXPECT_EQ(state(0.05, kRaised, kWithinItsLevel), CellState::Stable);
}

TEST_F(ChangeMapTest, AChangeLargerThanTheDistancesReachNeedsNone) {
    EXPECT_EQ(state(kReach_m + 0.2, kUnknown, kUnknown), CellState::Grown);
    EXPECT_EQ(state(-kReach_m - 0.2, kUnknown, kUnknown), CellState::Lost);
}

}  // namespace
}  // namespace divemesh::compare
