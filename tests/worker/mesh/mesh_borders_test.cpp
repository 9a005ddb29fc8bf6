#include "worker/mesh/mesh_borders.hpp"

#include <gtest/gtest.h>

#include "tests/worker/mesh/analytic_field.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::mesh {
namespace {

constexpr float kCell_m = 0.1F;

// Returns cells of kCell_m in the plane z = 0 where `present(x, y)`.
template <typename Present>
types::Mesh flat_cells(std::uint32_t num_x, std::uint32_t num_y, Present&& present) {
    types::Mesh mesh;
    for (std::uint32_t y = 0; y <= num_y; ++y)
        for (std::uint32_t x = 0; x <= num_x; ++x)
            mesh.vertices.emplace_back(
                kCell_m * static_cast<float>(x), kCell_m * static_cast<float>(y), 0.0F);
    for (std::uint32_t y = 0; y < num_y; ++y)
        for (std::uint32_t x = 0; x < num_x; ++x) {
            if (!present(x, y)) continue;
            const std::uint32_t corner = y * (num_x + 1) + x;
            mesh.triangles.push_back({corner, corner + 1, corner + num_x + 1});
            mesh.triangles.push_back({corner + 1, corner + num_x + 2, corner + num_x + 1});
        }
    return mesh;
}

TEST(MeshBorders, AClosedSurfaceHasNone) {
    const types::Mesh mesh =
        surface_nets(AnalyticField(sphere({0.01, 0.02, 0.0}, 0.15), 0.01, 3), {});
    const MeshBorders borders = find_borders(mesh);
    EXPECT_EQ(borders.num_holes, 0);
    EXPECT_EQ(borders.outer_edge_m, 0.0);
}

TEST(MeshBorders, ARectangleHasAnOuterEdgeAndNoHole) {
    const MeshBorders borders = find_borders(flat_cells(8, 5, [](auto, auto) { return true; }));
    EXPECT_EQ(borders.num_holes, 0);
    EXPECT_NEAR(borders.outer_edge_m, 2.6, 1e-5);
}

TEST(MeshBorders, HolesAreCountedWithTheirArea) {
    const MeshBorders borders = find_borders(flat_cells(10, 8, [](auto x, auto y) {
        const bool square = x >= 2 && x < 5 && y >= 2 && y < 4;
        return !square && !(x == 7 && y == 5);
    }));
    EXPECT_EQ(borders.num_holes, 2);
    EXPECT_NEAR(borders.hole_area_m2, 0.07, 1e-6);
    EXPECT_NEAR(borders.largest_hole_m2, 0.06, 1e-6);
    EXPECT_NEAR(borders.outer_edge_m, 3.6, 1e-5);
}

TEST(MeshBorders, HolesThatTouchInAVertexKeepTheirArea) {
    const MeshBorders borders = find_borders(flat_cells(
        6, 6, [](auto x, auto y) { return !(x == 2 && y == 2) && !(x == 3 && y == 3); }));
    EXPECT_GE(borders.num_holes, 1);
    EXPECT_LE(borders.num_holes, 2);
    EXPECT_NEAR(borders.hole_area_m2, 0.02, 1e-6);
}

TEST(MeshBorders, EachPartHasItsOwnOuterEdge) {
    const MeshBorders borders = find_borders(flat_cells(7, 3, [](auto x, auto) { return x != 3; }));
    EXPECT_EQ(borders.num_holes, 0);
    EXPECT_NEAR(borders.outer_edge_m, 2.4, 1e-5);
}

TEST(MeshBorders, AnEmptyMeshHasNone) { EXPECT_EQ(find_borders({}).num_holes, 0); }

}  // namespace
}  // namespace divemesh::mesh
