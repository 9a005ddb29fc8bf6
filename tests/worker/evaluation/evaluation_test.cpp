#include "worker/evaluation/evaluation.hpp"

#include <gtest/gtest.h>

namespace divemesh::evaluation {
namespace {

class EvaluationTest : public testing::Test {
protected:
    EvaluationTest() {
        rig_.cam0 = {640, 480, 490.0, 490.0, 320.0, 240.0};
        rig_.cam1 = rig_.cam0;
        rig_.T_imu_cam1.translation().x() = 0.1;
        for (int i = 0; i < 40; ++i)
            trajectory_.push_back(
                {i * std::int64_t{100'000'000},
                 Eigen::Isometry3d(Eigen::Translation3d(0.1 * i, 0.01 * i * i, 0.0))});
        mesh_.vertices = {{0, 0, 2}, {4, 0, 2}, {0, 4, 2}};
        mesh_.triangles = {{0, 1, 2}};
    }
    Evaluation evaluate(const types::Trajectory& truth) const {
        return evaluate_reconstruction(
            {rig_, trajectory_, trajectory_, {}, {}, {}, &mesh_, truth, known_, reference_});
    }

    types::Rig rig_;
    types::Trajectory trajectory_;
    types::Mesh mesh_;
    std::optional<types::Mesh> reference_;
    std::vector<dive::KnownDistance> known_ = {{"a", {0, 0, 2}, {1, 0, 2}, 1.0}};
};

TEST_F(EvaluationTest, WithoutTruthThereIsNothingToCompareWith) {
    const Evaluation evaluation = evaluate({});
    EXPECT_FALSE(evaluation.trajectory || evaluation.surface || evaluation.known_distances);
    ASSERT_EQ(evaluation.findings.size(), 1U);
    EXPECT_EQ(evaluation.findings[0].code, "known_distances_not_measured");
}

TEST_F(EvaluationTest, WithTruthAndReferenceAllErrorsAreThere) {
    reference_ = mesh_;
    const Evaluation evaluation = evaluate(trajectory_);
    ASSERT_TRUE(evaluation.trajectory && evaluation.causal && evaluation.surface);
    ASSERT_TRUE(evaluation.known_distances);
    EXPECT_LT(evaluation.surface->accuracy.rms_m, 1e-5);
    EXPECT_TRUE(evaluation.findings.empty());
}

// The positions of two segments relative to each other are a guess: here they are off by 5 m.
TEST_F(EvaluationTest, FinalAndCausalPathOfSeveralSegmentsAreComparedOverTheLargest) {
    constexpr std::size_t kSecond = 25;
    types::Trajectory apart = trajectory_;
    for (std::size_t i = kSecond; i < apart.size(); ++i)
        apart[i].T_world_imu.translation().x() += 5.0;
    const std::int64_t second_ns = apart[kSecond].timestamp_ns;
    const std::vector<types::Keyframe> keyframes = {
        {0, 0, Eigen::Isometry3d::Identity(), 0},
        {kSecond, second_ns, Eigen::Isometry3d::Identity(), 1}};
    const Evaluation evaluation = evaluate_reconstruction(
        {rig_, apart, apart, {}, keyframes, {second_ns}, &mesh_, trajectory_, known_, reference_});
    ASSERT_TRUE(evaluation.trajectory && evaluation.causal);
    for (const auto& error : {*evaluation.trajectory, *evaluation.causal}) {
        EXPECT_EQ(error.num_poses, static_cast<std::int64_t>(kSecond));
        EXPECT_LT(error.ate_rmse_m, 1e-9);
    }
}

TEST_F(EvaluationTest, TruthOfAnotherTimeIsAFindingAndNotAFailure) {
    reference_ = mesh_;
    types::Trajectory late = trajectory_;
    for (types::StampedPose& pose : late) pose.timestamp_ns += 1'000'000'000'000;
    const Evaluation evaluation = evaluate(late);
    EXPECT_FALSE(evaluation.trajectory || evaluation.surface);
    ASSERT_FALSE(evaluation.findings.empty());
    EXPECT_EQ(evaluation.findings[0].code, "ground_truth_unusable");
    EXPECT_EQ(evaluation.findings[0].severity, Severity::Warning);
}

TEST_F(EvaluationTest, WithoutASurfaceAllElseIsMeasured) {
    reference_ = mesh_;
    const Evaluation evaluation = evaluate_reconstruction(
        {rig_, trajectory_, trajectory_, {}, {}, {}, nullptr, trajectory_, known_, reference_});
    EXPECT_TRUE(evaluation.trajectory && evaluation.causal && evaluation.known_distances);
    EXPECT_FALSE(evaluation.surface.has_value());
    EXPECT_TRUE(evaluation.findings.empty());
}

TEST_F(EvaluationTest, AnEmptyMeshIsAFindingAndNotAFailure) {
    reference_ = mesh_;
    mesh_ = {};
    const Evaluation evaluation = evaluate(trajectory_);
    EXPECT_TRUE(evaluation.trajectory.has_value());
    EXPECT_FALSE(evaluation.surface.has_value());
    ASSERT_EQ(evaluation.findings.size(), 1U);
    EXPECT_EQ(evaluation.findings[0].code, "surface_not_measured");
}

}  // namespace
}  // namespace divemesh::evaluation
