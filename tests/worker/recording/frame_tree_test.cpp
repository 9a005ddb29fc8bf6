#include "worker/recording/frame_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/worker/recording/message_writer.hpp"

namespace divemesh::recording {
namespace {

const double kHalf = std::sqrt(0.5);  // a quarter turn in a quaternion

class FrameTreeTest : public testing::Test {
protected:
    void add(const std::vector<TestTransform>& transforms, Wire wire = Wire::Ros1) {
        const std::string bytes = transforms_message(wire, transforms);
        const auto kind = wire == Wire::Ros1 ? Serialization::Ros1 : Serialization::Cdr;
        for (const TransformMessage& message : parse_transforms(kind, bytes))
            tree_.add(message, findings_);
    }
    std::string codes() const {
        std::string text;
        for (const Finding& finding : findings_.all()) text += finding.code + " ";
        return text;
    }

    FrameTree tree_;
    dive::FindingLog findings_;
};

// The camera looks along x of the base, as optical frames do: its z is x there, its x is -y.
TEST_F(FrameTreeTest, AChainIsFollowedUpAndDownInEverySerialization) {
    for (const Wire wire : {Wire::Ros1, Wire::LittleCdr, Wire::BigCdr}) {
        tree_ = {};
        add({{"base", "imu", {0, 0, 0.5}, {0, 0, kHalf, kHalf}},  // a quarter turn about z
             {"/base", "mast", {1, 0, 0}, {0, 0, 0, 1}},
             {"mast", "/optical", {0, 2, 0}, {-0.5, 0.5, -0.5, 0.5}}},
            wire);
        const auto T_base_optical = tree_.between("base", "optical");
        ASSERT_TRUE(T_base_optical);
        EXPECT_LT((*T_base_optical * Eigen::Vector3d(3, 4, 5) - Eigen::Vector3d(6, -1, -4)).norm(),
                  1e-12);
        // The point (6, -1, -4) of the base is at (-1, -6, -4.5) in a frame turned by 90 degrees.
        const auto T_imu_optical = tree_.between("/imu", "optical");
        ASSERT_TRUE(T_imu_optical);
        EXPECT_LT(
            (*T_imu_optical * Eigen::Vector3d(3, 4, 5) - Eigen::Vector3d(-1, -6, -4.5)).norm(),
            1e-12);
        EXPECT_TRUE((*T_imu_optical * *tree_.between("optical", "imu"))
                        .isApprox(Eigen::Isometry3d::Identity(), 1e-12));
        EXPECT_EQ(codes(), "");
    }
}

TEST_F(FrameTreeTest, FramesThatNothingJoinsHaveNoTransform) {
    add({{"a", "b", {0, 0, 0}, {0, 0, 0, 1}}, {"c", "d", {0, 0, 0}, {0, 0, 0, 1}}});
    EXPECT_TRUE(tree_.between("a", "a"));
    EXPECT_FALSE(tree_.between("b", "d"));
    EXPECT_FALSE(tree_.between("a", "unknown"));
    EXPECT_FALSE(tree_.between("", ""));
}

TEST_F(FrameTreeTest, ACycleIsCutWhereItCloses) {
    add({{"a", "b", {1, 0, 0}, {0, 0, 0, 1}},
         {"b", "c", {1, 0, 0}, {0, 0, 0, 1}},
         {"c", "a", {1, 0, 0}, {0, 0, 0, 1}},
         {"d", "d", {1, 0, 0}, {0, 0, 0, 1}}});
    EXPECT_EQ(codes(), "transform_cycle transform_cycle ");
    EXPECT_EQ(tree_.between("a", "c")->translation().x(), 2.0);
}

TEST_F(FrameTreeTest, ASecondParentAndOtherNumbersAreLeftOut) {
    add({{"a", "b", {1, 0, 0}, {0, 0, 0, 1}},
         {"a", "b", {1, 0, 0}, {0, 0, 0, -1}},  // the same again: the same rotation
         {"c", "b", {2, 0, 0}, {0, 0, 0, 1}},
         {"a", "b", {3, 0, 0}, {0, 0, 0, 1}}});
    EXPECT_EQ(codes(), "transform_two_parents transform_changed ");
    EXPECT_EQ(tree_.between("a", "b")->translation().x(), 1.0);
}

TEST_F(FrameTreeTest, WhatIsNoTransformIsLeftOut) {
    const double nan = std::nan("");
    const double infinite = std::numeric_limits<double>::infinity();
    add({{"a", "b", {0, 0, 0}, {0, 0, 0, 0}},
         {"a", "b", {0, 0, 0}, {0, 0, 0, 1.01}},
         {"a", "b", {0, 0, 0}, {0, nan, 0, 1}},
         {"a", "b", {0, infinite, 0}, {0, 0, 0, 1}},
         {"a", "b", {0, 0, 0}, {0, 0, 0, infinite}},
         {"", "b", {0, 0, 0}, {0, 0, 0, 1}},
         {"a", std::string(2000, 'x'), {0, 0, 0}, {0, 0, 0, 1}}});
    EXPECT_EQ(findings_.all().size(), 7U);
    for (const Finding& finding : findings_.all()) EXPECT_EQ(finding.code, "transform_unusable");
    EXPECT_FALSE(tree_.between("a", "b"));
    add({{"a", "b", {0, 0, 0}, {0, 0, 0, 1.001}}});  // rounded
    EXPECT_TRUE(tree_.between("a", "b")->linear().isIdentity(1e-12));
}

TEST_F(FrameTreeTest, AChainOfTooManyFramesEndsInNoTime) {
    for (int i = 0; i < 20'000; ++i)
        add({{"f" + std::to_string(i), "f" + std::to_string(i + 1), {1, 0, 0}, {0, 0, 0, 1}},
             {"f100", "f0", {1, 0, 0}, {0, 0, 0, 1}}});
    // The root is f100: the transform from f99 to it would close a cycle.
    EXPECT_EQ(tree_.between("f100", "f0")->translation().x(), 1.0);
    EXPECT_EQ(tree_.between("f100", "f900")->translation().x(), 800.0);
    EXPECT_FALSE(tree_.between("f0", "f1001"));
}

}  // namespace
}  // namespace divemesh::recording
