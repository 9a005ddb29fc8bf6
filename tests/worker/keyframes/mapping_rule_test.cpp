#include "worker/keyframes/mapping_rule.hpp"

#include <gtest/gtest.h>

namespace divemesh::keyframes {
namespace {

constexpr double kDisparity_px = 30.0;  // at 2 m
constexpr double kStep = 0.02;          // 10 px

types::RectifiedRig rig() {
    types::RectifiedRig rig;
    rig.width_px = 500;
    rig.height_px = 400;
    rig.focal_px = 500.0;
    rig.baseline_m = 0.12;
    return rig;
}

types::Features features_at(double u_px) {
    types::Features features;
    for (int i = 0; i < 20; ++i) {
        types::Feature feature;
        feature.id = i;
        feature.pixel = {u_px + i, 100.0};
        features.push_back(feature);
    }
    return features;
}

bool is_due(double shift_px, const Eigen::Vector3d& moved_m, double step = kStep) {
    MappingRule rule(rig(), step);
    const types::Features before = features_at(100.0);
    const types::Features after = features_at(100.0 + shift_px);
    rule.taken({before, Eigen::Vector3d(3.0, 2.0, 1.0), kDisparity_px});
    return rule.due({after, Eigen::Vector3d(3.0, 2.0, 1.0) + moved_m, kDisparity_px});
}

TEST(MappingRuleTest, AFrameIsDueWhenTheImageHasMoved) {
    EXPECT_FALSE(is_due(9.0, Eigen::Vector3d::Zero()));
    EXPECT_TRUE(is_due(11.0, Eigen::Vector3d::Zero()));
}

// At 2 m a pixel is 4 mm wide.
TEST(MappingRuleTest, AFrameIsDueWhenTheCameraMovedAsFarForward) {
    EXPECT_FALSE(is_due(0.0, {0.0, 0.0, 0.036}));
    EXPECT_TRUE(is_due(0.0, {0.0, 0.0, 0.044}));
}

TEST(MappingRuleTest, WithoutAStepNoneIsDue) { EXPECT_FALSE(is_due(400.0, {1.0, 1.0, 1.0}, 0.0)); }

}  // namespace
}  // namespace divemesh::keyframes
