#include "worker/base/horn.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/stereo_world.hpp"

namespace divemesh::base {
namespace {

using synthetic::IsPoseWithin;

struct Pairs {
    std::vector<Eigen::Vector3d> a;
    std::vector<Eigen::Vector3d> b;
};

Eigen::Isometry3d known_transform() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = rotation_from_vector({0.4, -1.1, 2.0}).toRotationMatrix();
    T.translation() << 0.3, -2.0, 1.0;
    return T;
}

Pairs pairs(double scale, double noise_m) {
    synthetic::World random(1.0, 0.0, 7);
    Pairs result;
    for (int i = 0; i < 40; ++i) {
        result.a.emplace_back(random.normal(), random.normal(), random.normal());
        result.b.push_back(known_transform().linear() * (scale * result.a.back()) +
                           known_transform().translation() +
                           noise_m *
                               Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
    }
    return result;
}

TEST(HornTest, RecoversAKnownTransformExactly) {
    const auto [a, b] = pairs(1.0, 0.0);
    const auto found = absolute_orientation(a, b);

    ASSERT_TRUE(found);
    EXPECT_THAT(found->T_b_a, IsPoseWithin(known_transform(), 1e-6, 1e-9));
    EXPECT_NEAR(found->scale, 1.0, 1e-12);
}

TEST(HornTest, RecoversAKnownTransformFromNoisyPoints) {
    const auto [a, b] = pairs(1.0, 0.01);
    const auto found = absolute_orientation(a, b);

    ASSERT_TRUE(found);
    EXPECT_THAT(found->T_b_a, IsPoseWithin(known_transform(), 0.5, 0.006));
}

TEST(HornTest, ReportsTheScale) {
    const auto [a, b] = pairs(1.07, 0.0);
    EXPECT_NEAR(absolute_orientation(a, b)->scale, 1.07, 1e-9);
}

TEST(HornTest, RefusesPointsOnALine) {
    const std::vector<Eigen::Vector3d> line = {{0, 0, 1}, {1, 0, 1}, {2, 0, 1}, {5, 0, 1}};
    EXPECT_FALSE(absolute_orientation(line, line));
    EXPECT_FALSE(absolute_orientation({line[0], line[1]}, {line[0], line[1]}));
}

}  // namespace
}  // namespace divemesh::base
