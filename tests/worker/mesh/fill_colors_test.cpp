#include "worker/mesh/fill_colors.hpp"

#include <gtest/gtest.h>

namespace divemesh::mesh {
namespace {

// A strip of triangles whose vertex i is joined to i - 2 to i + 2.
types::Mesh strip(std::uint32_t num_vertices) {
    types::Mesh mesh;
    for (std::uint32_t i = 0; i < num_vertices; ++i)
        mesh.vertices.emplace_back(static_cast<float>(i / 2), static_cast<float>(i % 2), 0.0F);
    for (std::uint32_t i = 2; i < num_vertices; ++i) mesh.triangles.push_back({i - 2, i - 1, i});
    mesh.colors.assign(num_vertices, {0, 0, 0});
    return mesh;
}

TEST(FillColorsTest, AVertexTakesTheMeanOfItsColouredNeighbours) {
    types::Mesh mesh = strip(5);
    mesh.colors = {{10, 0, 0}, {20, 0, 0}, {0, 0, 0}, {30, 0, 0}, {40, 0, 0}};
    fill_colors(mesh, {1, 1, 0, 1, 1});
    // In its three triangles, 1 and 3 stand twice.
    EXPECT_EQ(mesh.colors[2], (types::Color{25, 0, 0}));
    EXPECT_EQ(mesh.colors[1], (types::Color{20, 0, 0}));
}

TEST(FillColorsTest, ColoursGoOnUntilAllVerticesHaveOne) {
    types::Mesh mesh = strip(40);
    std::vector<std::uint8_t> has_color(40, 0);
    mesh.colors[0] = {7, 8, 9};
    has_color[0] = 1;
    fill_colors(mesh, has_color);
    for (const types::Color& color : mesh.colors) EXPECT_EQ(color, (types::Color{7, 8, 9}));
}

TEST(FillColorsTest, BlackOfTheImagesStaysAndNothingIsInvented) {
    types::Mesh mesh = strip(4);
    mesh.colors[3] = {90, 90, 90};
    types::Mesh apart = strip(3);
    fill_colors(mesh, {1, 1, 1, 1});
    fill_colors(apart, {0, 0, 0});
    EXPECT_EQ(mesh.colors[0], (types::Color{0, 0, 0}));
    EXPECT_EQ(apart.colors[1], (types::Color{0, 0, 0}));
}

}  // namespace
}  // namespace divemesh::mesh
