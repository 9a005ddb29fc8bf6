#include "worker/mesh/cut_by_sigma.hpp"

#include <gtest/gtest.h>

namespace divemesh::mesh {
namespace {

// Returns a strip of triangles along x; each vertex has the sigma of its place in the list.
types::Mesh strip(const std::vector<float>& sigma_m) {
    types::Mesh mesh;
    for (std::size_t i = 0; i < sigma_m.size(); ++i) {
        mesh.vertices.emplace_back(static_cast<float>(i), static_cast<float>(i % 2), 0.0F);
        mesh.normals.emplace_back(0.0F, 0.0F, 1.0F);
        mesh.colors.push_back({static_cast<std::uint8_t>(i), 0, 0});
        mesh.num_observations.push_back(static_cast<std::uint32_t>(i));
        mesh.voxel_m.push_back(static_cast<float>(i));
    }
    mesh.sigma_m = sigma_m;
    for (std::uint32_t i = 0; i + 2 < sigma_m.size(); ++i)
        mesh.triangles.push_back({i, i + 1, i + 2});
    return mesh;
}

TEST(CutBySigma, ATriangleGoesWithItsWorstVertex) {
    const types::Mesh cut =
        cut_by_sigma(strip({0.001F, 0.002F, 0.001F, 0.002F, 0.009F, 0.001F, 0.001F}), 0.005);
    ASSERT_EQ(cut.triangles.size(), 2U) << "the others touch the vertex of 9 mm";
    ASSERT_EQ(cut.vertices.size(), 4U);
    for (std::uint32_t i = 0; i < 4; ++i) {
        EXPECT_EQ(cut.vertices[i].x(), static_cast<float>(i));
        EXPECT_EQ(cut.num_observations[i], i);
        EXPECT_EQ(cut.voxel_m[i], static_cast<float>(i));
        EXPECT_LE(cut.sigma_m[i], 0.005F);
    }
}

TEST(CutBySigma, WhatIsKnownWellStaysAsItIs) {
    const types::Mesh mesh = strip({0.001F, 0.002F, 0.001F, 0.002F});
    const types::Mesh cut = cut_by_sigma(mesh, 0.0025);
    EXPECT_EQ(cut.vertices, mesh.vertices);
    EXPECT_EQ(cut.triangles, mesh.triangles);
}

TEST(CutBySigma, NothingIsLeftOfAVagueSurface) {
    const types::Mesh cut = cut_by_sigma(strip({0.01F, 0.01F, 0.01F}), 0.005);
    EXPECT_TRUE(cut.triangles.empty());
    EXPECT_TRUE(cut.vertices.empty());
}

TEST(CutBySigma, AMeshWithoutSigmaStaysWhole) {
    types::Mesh mesh = strip({0.01F, 0.01F, 0.01F});
    mesh.sigma_m.clear();
    EXPECT_EQ(cut_by_sigma(mesh, 0.005).triangles.size(), 1U);
}

}  // namespace
}  // namespace divemesh::mesh
