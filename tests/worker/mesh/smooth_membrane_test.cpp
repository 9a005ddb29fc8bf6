#include "worker/mesh/smooth_membrane.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/worker/mesh/analytic_field.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::mesh {
namespace {

constexpr double kVoxel_m = 0.01;

// Returns cells of one voxel in the plane z = 0, with corners displaced along z by noise of
// `sigma_m`.
types::Mesh noisy_plane(std::uint32_t num_cells, float sigma_m) {
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0.0F, sigma_m);
    types::Mesh mesh;
    for (std::uint32_t y = 0; y <= num_cells; ++y)
        for (std::uint32_t x = 0; x <= num_cells; ++x) {
            mesh.vertices.emplace_back(
                0.01F * static_cast<float>(x), 0.01F * static_cast<float>(y), noise(random));
            mesh.normals.emplace_back(0, 0, 1);
            mesh.sigma_m.push_back(sigma_m);
            mesh.voxel_m.push_back(static_cast<float>(kVoxel_m));
        }
    for (std::uint32_t y = 0; y < num_cells; ++y)
        for (std::uint32_t x = 0; x < num_cells; ++x) {
            const std::uint32_t corner = y * (num_cells + 1) + x;
            mesh.triangles.push_back({corner, corner + 1, corner + num_cells + 1});
            mesh.triangles.push_back({corner + 1, corner + num_cells + 2, corner + num_cells + 1});
        }
    return mesh;
}

// Returns the RMS height of the vertices that are at least `margin` cells away from every border.
double rms_height_m(const types::Mesh& mesh, std::uint32_t num_cells, std::uint32_t margin) {
    double sum = 0.0;
    int num = 0;
    for (std::uint32_t y = margin; y <= num_cells - margin; ++y)
        for (std::uint32_t x = margin; x <= num_cells - margin; ++x, ++num)
            sum += std::pow(mesh.vertices[y * (num_cells + 1) + x].z(), 2);
    return std::sqrt(sum / num);
}

// With L = 10 voxels the membrane's low-pass is 1 / (1 + L^2 q), q = (kx^2 + ky^2 - kx ky) / 3 on
// these triangles. Applied twice, it leaves (4 - 2 + 1/3) / (4 pi L^2 sqrt(det q)) (integral over
// wave numbers k) of the variance sigma^2 of white noise: 0.080 sigma.
TEST(SmoothMembrane, WhiteNoiseOnAPlaneGoesDownAsTheMembraneSays) {
    types::Mesh mesh = noisy_plane(200, 0.02F);
    smooth_membrane(mesh, 2);
    EXPECT_NEAR(rms_height_m(mesh, 200, 70) / 0.02, 0.080, 0.012);
    EXPECT_GT(mesh.normals[100 * 201 + 100].z(), 0.95F);
}

TEST(SmoothMembrane, WhatIsKnownWellStaysPut) {
    const types::Mesh sharp = noisy_plane(40, 0.004F);
    types::Mesh mesh = sharp;
    smooth_membrane(mesh, 1);
    EXPECT_EQ(mesh.vertices, sharp.vertices);
}

struct AtRest {
    Eigen::VectorXd heights_m;
    std::vector<bool> on_border;
};

// Returns where the membrane comes to rest, by a direct solver.
AtRest at_rest(const types::Mesh& mesh) {
    const auto num = static_cast<Eigen::Index>(mesh.vertices.size());
    Eigen::MatrixXi arrives = Eigen::MatrixXi::Zero(num, num);  // triangles that go from i to j
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) ++arrives(t[k], t[(k + 1) % 3]);
    std::vector<bool> on_border;
    Eigen::MatrixXd system = Eigen::MatrixXd::Identity(num, num);
    for (Eigen::Index i = 0; i < num; ++i) {
        const Eigen::VectorXi once = arrives.row(i).transpose() + arrives.col(i);
        const bool border = arrives.row(i).transpose() != arrives.col(i);
        on_border.push_back(border);
        const Eigen::VectorXd weights = border ? (once.array() == 1).cast<double>().matrix().eval()
                                               : arrives.row(i).transpose().cast<double>().eval();
        if (weights.sum() == 0.0) continue;
        const double reach = std::min(12.0, mesh.sigma_m[i] / kVoxel_m / 0.2);
        system.row(i) -= weights.transpose() / weights.sum() / (1.0 + 1.0 / (reach * reach));
        system.row(i) *= 1.0 + reach * reach;
    }
    Eigen::VectorXd measured(num);
    for (Eigen::Index i = 0; i < num; ++i) measured[i] = mesh.vertices[i].z();
    const Eigen::PartialPivLU<Eigen::MatrixXd> solver(system);
    const Eigen::VectorXd places = solver.solve(measured);
    return {places + solver.solve(measured - places), on_border};
}

// A grid with some triangles missing has borders of every kind, and vertices where two of its parts
// meet.
TEST(SmoothMembrane, ComesToRestOnATornSurface) {
    constexpr std::uint32_t kCells = 22;
    for (unsigned seed = 1; seed <= 10; ++seed) {
        types::Mesh mesh = noisy_plane(kCells, 0.02F);
        std::mt19937 random(seed);
        std::erase_if(mesh.triangles, [&](const auto&) { return random() % 5 == 0; });
        const AtRest expected = at_rest(mesh);
        smooth_membrane(mesh, 1);
        double worst_m = 0.0;
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
            if (!expected.on_border[i])  // border vertices move along their normals only
                worst_m = std::max(worst_m, std::abs(mesh.vertices[i].z() - expected.heights_m[i]));
        EXPECT_LT(worst_m, 0.5 * 0.02) << "seed " << seed;
    }
}

TEST(SmoothMembrane, BordersAreSmoothedButKeepTheirOutline) {
    const types::Mesh before = noisy_plane(100, 0.02F);
    types::Mesh mesh = before;
    smooth_membrane(mesh, 1);
    double heights = 0.0;
    for (std::uint32_t i = 10; i <= 90; ++i) {
        EXPECT_LT((mesh.vertices[i] - before.vertices[i]).head<2>().norm(), 0.015F);
        heights += std::pow(mesh.vertices[i].z(), 2);
    }
    EXPECT_LT(std::sqrt(heights / 81), 0.35 * 0.02);
}

TEST(SmoothMembrane, ABallKeepsItsSize) {
    const Eigen::Vector3f center(0.013F, -0.007F, 0.021F);
    types::Mesh mesh = surface_nets(AnalyticField(sphere(center.cast<double>(), 0.3), kVoxel_m, 6),
                                    {.num_threads = 2});
    mesh.sigma_m.assign(mesh.vertices.size(), 0.02F);
    smooth_membrane(mesh, 2);
    double sum_m = 0.0;
    for (const auto& vertex : mesh.vertices) sum_m += (vertex - center).norm();
    EXPECT_NEAR(sum_m / static_cast<double>(mesh.vertices.size()), 0.3, 0.1 * 0.02);
}

TEST(SmoothMembrane, NothingMovesFartherThanThreeSigmas) {
    const types::Mesh before = noisy_plane(60, 0.02F);
    types::Mesh mesh = before;
    mesh.vertices[30 * 61 + 30].z() = 0.5F;
    smooth_membrane(mesh, 1);
    EXPECT_NEAR(mesh.vertices[30 * 61 + 30].z(), 0.5F - 0.06F, 1e-4F);
}

// The membrane of a vertex depends on sigma in its own voxels alone.
TEST(SmoothMembrane, ALargerVoxelIsSmoothedLikeASmallerOne) {
    types::Mesh small = noisy_plane(60, 0.02F);
    types::Mesh large = small;
    for (auto& vertex : large.vertices) vertex *= 2.0F;
    for (float& sigma_m : large.sigma_m) sigma_m *= 2.0F;
    for (float& voxel_m : large.voxel_m) voxel_m *= 2.0F;
    smooth_membrane(small, 1);
    smooth_membrane(large, 1);
    ASSERT_FALSE(small.vertices.empty());
    ASSERT_EQ(large.vertices.size(), small.vertices.size());
    for (std::size_t i = 0; i < small.vertices.size(); ++i)
        EXPECT_EQ(2.0F * small.vertices[i], large.vertices[i]);
}

TEST(SmoothMembrane, OneThreadAndTwoGiveTheSameBytes) {
    types::Mesh one = noisy_plane(100, 0.02F);
    types::Mesh two = one;
    smooth_membrane(one, 1);
    smooth_membrane(two, 2);
    EXPECT_EQ(one.vertices, two.vertices);
    EXPECT_EQ(one.normals, two.normals);
}

}  // namespace
}  // namespace divemesh::mesh
