#include "worker/texture/face_graph.hpp"

#include <gtest/gtest.h>

#include "tests/worker/texture/square_mesh.hpp"

namespace divemesh::texture {
namespace {

void expect_consistent(const FaceGraph& graph) {
    for (std::size_t face = 0; face < graph.num_faces(); ++face)
        for (const FaceLink& link : graph.links(face)) {
            EXPECT_NE(link.face, face);
            const FaceLink& back = graph.links(link.face)[link.back - graph.first_link(link.face)];
            EXPECT_EQ(back.face, face);
            EXPECT_EQ(back.edge_m, link.edge_m);
        }
}

TEST(FaceGraph, LinksTheTrianglesOfEachInnerEdge) {
    const FaceGraph graph(square_mesh(1.0F, 10));
    expect_consistent(graph);
    // 40 of the 320 edges are at the border.
    EXPECT_EQ(graph.num_links(), 2U * (320U - 40U));
    ASSERT_EQ(graph.links(0).size(), 2U);  // a corner cell: the diagonal, and the cell to the right
    EXPECT_EQ(graph.links(0)[0].face, 1U);
    EXPECT_FLOAT_EQ(graph.links(0)[0].edge_m, std::sqrt(0.02F));
}

TEST(FaceGraph, ATriangleThatHasAnEdgeTwiceIsNotItsOwnNeighbour) {
    types::Mesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 0}, {0, 1, 2}};
    const FaceGraph graph(mesh);
    expect_consistent(graph);
    EXPECT_EQ(graph.num_links(), 2U);
    ASSERT_EQ(graph.links(1).size(), 1U);
    EXPECT_EQ(graph.links(1)[0].face, 0U);
}

TEST(FaceGraph, GroupsHaveNoNeighbours) {
    const FaceGraph graph(square_mesh(1.0F, 10));
    const auto groups = independent_faces(graph);
    EXPECT_LE(groups.size(), 4U);
    std::vector<int> group_of(graph.num_faces(), -1);
    for (std::size_t group = 0; group < groups.size(); ++group)
        for (const std::uint32_t face : groups[group]) group_of[face] = static_cast<int>(group);
    for (std::size_t face = 0; face < graph.num_faces(); ++face) {
        EXPECT_GE(group_of[face], 0);
        for (const FaceLink& link : graph.links(face))
            EXPECT_NE(group_of[face], group_of[link.face]);
    }
}

// A book whose pages share one edge, with a page that has no area and one that is there twice.
TEST(FaceGraph, ManyTrianglesOfOneEdgeAreAChain) {
    constexpr std::uint32_t kNumPages = 1000;
    types::Mesh book;
    book.vertices = {{0.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}};
    for (std::uint32_t page = 0; page < kNumPages; ++page) {
        book.vertices.emplace_back(1.0F, static_cast<float>(page), 0.0F);
        book.triangles.push_back({0, 1, page + 2});
    }
    book.triangles.push_back({0, 0, 1});
    book.triangles.push_back(book.triangles.front());
    const FaceGraph graph(book);
    expect_consistent(graph);
    EXPECT_LE(graph.num_links(), 2U * (kNumPages + 4U));
    EXPECT_GE(graph.num_links(), 2U * kNumPages);
}

}  // namespace
}  // namespace divemesh::texture
