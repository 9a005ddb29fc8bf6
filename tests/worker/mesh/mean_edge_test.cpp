#include "worker/mesh/mean_edge.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/rough_ground.hpp"

namespace divemesh::mesh {
namespace {

types::Mesh level_ground(double step_m) {
    return synthetic::ground_mesh([](double, double) { return 0.0; }, 1.0, 1.0, step_m, 0.0, 1);
}

TEST(MeanEdgeTest, EachVertexOfASquareGridHasItsStepAsSpacing) {
    const types::Mesh fine = level_ground(0.02);
    const types::Mesh both = synthetic::joined(fine, level_ground(0.08));
    const std::vector<float> spacing_m = vertex_spacing_m(both);
    ASSERT_EQ(spacing_m.size(), both.vertices.size());
    for (std::size_t i = 0; i < spacing_m.size(); ++i)
        EXPECT_NEAR(spacing_m[i], i < fine.vertices.size() ? 0.02F : 0.08F, 1e-5F);
    EXPECT_LT(mean_edge_m(both), 0.025);  // of the triangles, most of which are small
}

TEST(MeanEdgeTest, AVertexWithoutTrianglesHasNoSpacing) {
    types::Mesh mesh = level_ground(0.5);
    mesh.vertices.emplace_back(0.0F, 0.0F, 9.0F);
    EXPECT_EQ(vertex_spacing_m(mesh).back(), 0.0F);
}

}  // namespace
}  // namespace divemesh::mesh
