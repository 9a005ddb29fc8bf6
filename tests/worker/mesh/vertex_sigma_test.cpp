#include "worker/mesh/vertex_sigma.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace divemesh::mesh {
namespace {

constexpr int kEdge = 21;
constexpr double kVoxel_m = 0.01;

// Returns a sheet of vertices one voxel apart, bent about y with a radius; 0: flat.
types::Mesh sheet(double radius_m, float sigma_m, std::uint32_t num_views) {
    types::Mesh mesh;
    for (int y = 0; y < kEdge; ++y)
        for (int x = 0; x < kEdge; ++x) {
            const double along = kVoxel_m * (x - kEdge / 2);
            const double rotation = radius_m > 0.0 ? along / radius_m : 0.0;
            const Eigen::Vector3d p = radius_m > 0.0
                                          ? Eigen::Vector3d(radius_m * std::sin(rotation),
                                                            kVoxel_m * y,
                                                            radius_m * (std::cos(rotation) - 1.0))
                                          : Eigen::Vector3d(along, kVoxel_m * y, 0.0);
            mesh.vertices.push_back(p.cast<float>());
            mesh.normals.push_back(
                Eigen::Vector3d(std::sin(rotation), 0.0, std::cos(rotation)).cast<float>());
        }
    for (std::uint32_t y = 0; y + 1 < kEdge; ++y)
        for (std::uint32_t x = 0; x + 1 < kEdge; ++x) {
            const std::uint32_t a = y * kEdge + x, b = a + 1, c = a + kEdge, d = c + 1;
            mesh.triangles.push_back({a, b, d});
            mesh.triangles.push_back({a, d, c});
        }
    mesh.sigma_m.assign(mesh.vertices.size(), sigma_m);
    mesh.voxel_m.assign(mesh.vertices.size(), static_cast<float>(kVoxel_m));
    mesh.num_observations.assign(mesh.vertices.size(), num_views);
    return mesh;
}

float at_middle(const types::Mesh& mesh) { return mesh.sigma_m[kEdge * kEdge / 2]; }

TEST(VertexSigmaTest, MatchesTheSpreadOfTrialsWithCorrelatedViewErrors) {
    constexpr int kNumViews = 30;
    constexpr int kNumTrials = 20'000;
    constexpr double kOne_px = 0.15, kShared_px = 0.035, kMetrePerPx = 0.06;
    const double own_px = std::sqrt(kOne_px * kOne_px - kShared_px * kShared_px);
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    double squares = 0.0;
    for (int trial = 0; trial < kNumTrials; ++trial) {
        double mean_px = kShared_px * normal(random);
        for (int view = 0; view < kNumViews; ++view) mean_px += own_px * normal(random) / kNumViews;
        squares += std::pow(kMetrePerPx * mean_px, 2.0) / kNumTrials;
    }

    types::Mesh plane = sheet(
        0.0, static_cast<float>(kMetrePerPx * kOne_px / std::sqrt(double{kNumViews})), kNumViews);
    finish_sigma(plane, 0.0);
    EXPECT_NEAR(at_middle(plane), std::sqrt(squares), 0.05 * std::sqrt(squares));
}

TEST(VertexSigmaTest, IncludesTheSagThatAveragingCausesOnABend) {
    constexpr double kRadius_m = 0.2;
    constexpr double kReach_m = 4.4 * kVoxel_m;
    double sagged_m = 0.0;  // mean depth of the arc below its crown, within the reach
    constexpr int kNum = 1000;
    for (int i = 0; i < kNum; ++i) {
        const double x = kReach_m * (i + 0.5) / kNum;
        sagged_m += (kRadius_m - std::sqrt(kRadius_m * kRadius_m - x * x)) / kNum;
    }
    types::Mesh bend = sheet(kRadius_m, 0.0F, 5);
    finish_sigma(bend, 0.0);
    EXPECT_NEAR(at_middle(bend), sagged_m, 0.15 * sagged_m);
}

TEST(VertexSigmaTest, IncludesThePoseErrorAndKeepsTheShape) {
    const types::Mesh before = sheet(0.0, 0.003F, 1);
    types::Mesh after = before;
    finish_sigma(after, 0.004);
    EXPECT_NEAR(at_middle(after), 0.005, 1e-6);
    EXPECT_NEAR(after.sigma_local_m[kEdge * kEdge / 2], 0.003, 1e-6);
    EXPECT_EQ(after.vertices, before.vertices);
    EXPECT_EQ(after.normals, before.normals);
    EXPECT_EQ(after.triangles, before.triangles);
}

TEST(VertexSigmaTest, AMeshWithoutSigmaStaysWithout) {
    types::Mesh bare = sheet(0.0, 0.0F, 1);
    bare.sigma_m.clear();
    finish_sigma(bare, 0.004);
    EXPECT_TRUE(bare.sigma_m.empty());
}

}  // namespace
}  // namespace divemesh::mesh
