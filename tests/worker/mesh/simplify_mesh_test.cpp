#include "worker/mesh/simplify_mesh.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/worker/mesh/analytic_field.hpp"
#include "worker/mesh/mesh_components.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::mesh {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadius_m = 0.3;

types::Mesh ball() {
    return surface_nets(AnalyticField(sphere({0.013, -0.007, 0.021}, kRadius_m), 0.01, 6), {});
}

TEST(SimplifyMesh, ABallOfATenthOfItsTrianglesKeepsShapeTopologyAndAttributes) {
    const types::Mesh mesh = ball();
    const types::Mesh fewer = simplify_mesh(mesh, {.share = 0.1});
    EXPECT_LE(fewer.triangles.size(), mesh.triangles.size() / 10 + 1);
    EXPECT_GE(fewer.triangles.size(), mesh.triangles.size() / 11);
    const MeshTopology topology = check_topology(fewer);
    EXPECT_EQ(topology.num_border_edges, 0);
    EXPECT_EQ(topology.num_misoriented_edges, 0);
    EXPECT_EQ(topology.euler_characteristic, 2);
    EXPECT_NEAR(topology.volume_m3 / (4.0 / 3.0 * kPi * std::pow(kRadius_m, 3)), 1.0, 0.02);
    ASSERT_EQ(fewer.normals.size(), fewer.vertices.size());
    ASSERT_EQ(fewer.sigma_m.size(), fewer.vertices.size());
    for (std::size_t i = 0; i < fewer.vertices.size(); ++i) {
        const Eigen::Vector3f out = fewer.vertices[i] - Eigen::Vector3f(0.013F, -0.007F, 0.021F);
        EXPECT_GT(fewer.normals[i].dot(out.normalized()), 0.99F);
    }
}

TEST(SimplifyMesh, TheLimitOfErrorEndsItSooner) {
    const types::Mesh mesh = ball();
    const types::Mesh tight = simplify_mesh(mesh, {.share = 0.01, .max_error_m = 0.0002});
    const types::Mesh loose = simplify_mesh(mesh, {.share = 0.01, .max_error_m = 0.002});
    EXPECT_GT(tight.triangles.size(), 2 * loose.triangles.size());
    EXPECT_GT(loose.triangles.size(), mesh.triangles.size() / 100 + 1);
}

TEST(SimplifyMesh, AnEmptyMeshStaysEmpty) {
    EXPECT_TRUE(simplify_mesh({}, {.share = 0.5}).triangles.empty());
}

}  // namespace
}  // namespace divemesh::mesh
