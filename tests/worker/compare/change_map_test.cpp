#include "worker/compare/change_map.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/rough_ground.hpp"
#include "worker/compare/change_sums.hpp"

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

// The later dive is a copy of the earlier one that the co-registration left off by a small motion.
TEST_F(ChangeMapTest, ItsResponseToAMotionSaysByHowMuchTheVolumeOfAPartChanges) {
    const types::Mesh a = ground_mesh(synthetic::rough_ground(3), 1.0, 1.0, 0.02, 0.0, 1);
    const std::vector<M3c2Distance> distances(a.vertices.size());
    const std::optional<Views> unchecked;
    const auto map_of = [&](const types::Mesh& b) {
        return map_changes({a, distances, unchecked},
                           {b, distances, unchecked},
                           CoRegistration{},
                           {.grid = {0.02, {-1.0, 1.0}, 100, 100},
                            .scale_m = 0.08,
                            .reach_m = kReach_m,
                            .num_threads = 1});
    };
    const Eigen::Vector3d rotation(0.002, -0.001, 0.003);
    const Eigen::Vector3d shift_m(0.002, 0.001, 0.0015);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
    T.translation() = shift_m;
    cv::Mat cells = cv::Mat::zeros(100, 100, CV_8U);
    cells(cv::Rect(35, 5, 55, 60)) = cv::Scalar::all(255);  // to the north-east of the pivot

    const Vector6d by_motion = sum_over(map_of(a), cells).by_motion;
    const double volume_m3 = sum_over(map_of(synthetic::moved(a, T)), cells).volume_m3;

    const double expected_m3 = by_motion.head<3>().dot(rotation) + by_motion.tail<3>().dot(shift_m);
    EXPECT_GT(std::abs(expected_m3), 1e-3);
    EXPECT_NEAR(volume_m3, expected_m3, 0.05 * std::abs(expected_m3));
}

}  // namespace
}  // namespace divemesh::compare
