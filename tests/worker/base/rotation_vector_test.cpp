#include "worker/base/rotation_vector.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace divemesh::base {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
const Eigen::Vector3d kAxis = Eigen::Vector3d(1.0, -2.0, 2.0) / 3.0;

TEST(RotationVectorTest, TheVectorOfARotationGivesTheRotationBack) {
    for (const double angle : {0.0, 1e-14, 1e-3, 1.0, 3.14}) {
        const Eigen::Vector3d w = angle * kAxis;
        EXPECT_LT((vector_from_rotation(rotation_from_vector(w)) - w).norm(), 1e-12) << angle;
    }
}

TEST(RotationVectorTest, AQuarterTurnAboutZTakesXToY) {
    const Eigen::Vector3d turned =
        rotation_from_vector({0.0, 0.0, 90.0 * kDegree}) * Eigen::Vector3d::UnitX();
    EXPECT_LT((turned - Eigen::Vector3d::UnitY()).norm(), 1e-15);
}

TEST(RotationVectorTest, BelowThreeDegreesTheSmallOnesAreGoodToATenThousandth) {
    const Eigen::Vector3d w = 2.9 * kDegree * kAxis;
    const Eigen::Quaterniond q = rotation_from_vector(w);
    EXPECT_LT((vector_from_small_rotation(q) - w).norm(), 1.2e-4 * w.norm());
    EXPECT_LT(q.angularDistance(rotation_from_small_vector(w)), 2.2e-4 * w.norm());
}

TEST(RotationVectorTest, AQuaternionAndItsNegativeAreOneRotation) {
    const Eigen::Quaterniond q = rotation_from_vector(0.01 * kAxis);
    const Eigen::Quaterniond negative(-q.coeffs());
    EXPECT_EQ(vector_from_small_rotation(q), vector_from_small_rotation(negative));
    EXPECT_LT((vector_from_rotation(q) - vector_from_rotation(negative)).norm(), 1e-15);
}

}  // namespace
}  // namespace divemesh::base
