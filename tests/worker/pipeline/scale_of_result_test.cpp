#include "worker/pipeline/scale_of_result.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

#include "tests/temporary_folder.hpp"
#include "worker/io/covariance_file.hpp"
#include "worker/io/ply.hpp"
#include "worker/optimisation/expected_path_error.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kSigma_m = 1e-4;
constexpr double kNormal975 = 1.959964;

// The result of a dive that swam 4 m along x, 2 m above a triangle, and measured a bar of a metre.
class ScaleOfResultTest : public testing::Test {
protected:
    ScaleOfResultTest() {
        simulator::simulate({.scene = simulator::SceneKind::Tank,
                             .out = folder_ / "dive",
                             .length_m = 0.2,
                             .rate_hz = 8.0,
                             .width_px = 160,
                             .height_px = 120});
        request_.dive = folder_ / "dive";
        request_.out = folder_ / "model";
        request_.scratch = folder_ / "scratch";
        request_.options = make_options("standard", {{"use_imu", false}, {"use_pressure", false}});
        made_ = std::make_unique<Reconstruction>(request_);
        std::vector<Eigen::Vector3d> positions;
        for (int i = 0; i <= 4; ++i) {
            positions.emplace_back(i, 0.0, 0.0);
            made_->optimised.trajectory.push_back(
                {i, Eigen::Isometry3d(Eigen::Translation3d(positions.back()))});
            made_->optimised.covariances.push_back(
                {i, kSigma_m * kSigma_m * Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero()});
        }
        types::PathUncertainty& path = made_->optimised.statistics.path;
        path = {.mean_square_m2 = 1e-5, .degrees_of_freedom = 2.0};
        path.scale_sigma = path.shared_scale_sigma = 0.002;
        path.spread_m2 = optimisation::spread_m2(positions);
        made_->markers.emplace();
        made_->markers->bars.resize(2);  // the second was not found
        made_->markers->bars[0].measured_m = 1.0;
        made_->markers->bars[0].sigma_m = 0.001;
        types::Mesh& mesh = made_->surface.mesh;
        mesh.vertices = {{1.0F, 0.0F, -2.0F}, {2.0F, 0.0F, -2.0F}, {2.0F, 1.0F, -2.0F}};
        mesh.normals.assign(3, Eigen::Vector3f::UnitZ());
        mesh.sigma_m.assign(3, 0.003F);
        mesh.triangles = {{0, 1, 2}};
    }
    // Has the bars say that all lengths are `factor` times as long.
    bool cover(double factor) {
        made_->markers->trusted_scale = markers::MarkerScale{factor, 0.001, 1, {}};
        return cover_contradiction(*made_);
    }

    TemporaryFolder folder_;
    ReconstructionRequest request_;
    std::unique_ptr<Reconstruction> made_;
};

TEST_F(ScaleOfResultTest, AScaleThatContradictsLiesWithinAllThatIsStated) {
    ASSERT_TRUE(cover(1.1));

    EXPECT_NEAR(made_->optimised.statistics.path.scale_contradiction, 0.1, 1e-12);
    const auto covariances = io::read_covariances(made_->artifact("trajectory_covariance.csv"));
    EXPECT_NEAR(std::sqrt(covariances.back().position_m2(0, 0)),
                std::hypot(kSigma_m, 0.1 * 4.0 / kNormal975),
                1e-6);
    EXPECT_NEAR(covariances.back().position_m2(1, 1), kSigma_m * kSigma_m, 1e-12);
    const types::Mesh mesh = io::read_ply(made_->artifact("mesh.ply"));
    EXPECT_NEAR(mesh.sigma_m.at(0), std::hypot(0.003, 0.1 * 2.0 / kNormal975), 1e-6);
    EXPECT_NEAR(made_->markers->bars[0].sigma_m, std::hypot(0.001, 0.1 / kNormal975), 1e-6);
    EXPECT_EQ(made_->markers->bars[1].sigma_m, 0.0);
    // What the sources are judged by stays as it was.
    EXPECT_NEAR(made_->optimised.covariances.back().position_m2(0, 0), kSigma_m * kSigma_m, 1e-12);
    EXPECT_EQ(made_->optimised.statistics.path.scale_sigma, 0.002);
}

TEST_F(ScaleOfResultTest, AScaleThatAgreesChangesNothing) {
    EXPECT_FALSE(cover(1.002));
    EXPECT_EQ(made_->optimised.statistics.path.scale_contradiction, 0.0);
    EXPECT_EQ(made_->markers->bars[0].sigma_m, 0.001);
    EXPECT_FALSE(std::filesystem::exists(made_->artifact("mesh.ply")));
}

}  // namespace
}  // namespace divemesh::pipeline
