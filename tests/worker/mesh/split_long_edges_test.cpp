#include "worker/mesh/split_long_edges.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "worker/types/triangle_area.hpp"

namespace divemesh::mesh {
namespace {

// A floor of 1 x 1 m whose colour and sigma are linear in x, in two triangles beside a smaller one.
types::Mesh floor() {
    types::Mesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1.1F, 0.5F, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}};
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
        mesh.normals.emplace_back(Eigen::Vector3f::UnitZ());
        mesh.colors.push_back({static_cast<std::uint8_t>(200.0F * vertex.x()), 0, 0});
        mesh.sigma_m.push_back(0.01F * vertex.x());
    }
    return mesh;
}

TEST(SplitLongEdgesTest, NoEdgeIsTooLongAndTheSurfaceIsTheSame) {
    const types::Mesh before = floor();
    const types::Mesh after = split_long_edges(before, std::vector<float>(5, 0.13F));
    double area_m2 = 0.0;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const auto& triangle : after.triangles) {
        const Eigen::Vector3f& a = after.vertices[triangle[0]];
        const Eigen::Vector3f normal =
            (after.vertices[triangle[1]] - a).cross(after.vertices[triangle[2]] - a);
        EXPECT_GT(normal.z(), 0.0F) << "turned over, or without area";
        area_m2 += types::triangle_area_m2(after, triangle);
        for (std::size_t i = 0; i < 3; ++i) {
            const auto& p = after.vertices[triangle[i]];
            const auto& q = after.vertices[triangle[(i + 1) % 3]];
            EXPECT_LE((p - q).norm(), 0.13F);
            ++sides[std::minmax(triangle[i], triangle[(i + 1) % 3])];
        }
    }
    EXPECT_NEAR(area_m2, 1.0 + 0.5 * 0.1, 1e-6);
    // Without cracks only what lies on the outline belongs to one triangle.
    double outline_m = 0.0;
    for (const auto& [side, num] : sides) {
        ASSERT_LE(num, 2);
        if (num == 1)
            outline_m += static_cast<double>(
                (after.vertices[side.first] - after.vertices[side.second]).norm());
    }
    EXPECT_NEAR(outline_m, 3.0 + 2.0 * std::hypot(0.1, 0.5), 1e-5);
}

TEST(SplitLongEdgesTest, NewVerticesHaveTheMeanOfTheirEnds) {
    const types::Mesh after = split_long_edges(floor(), std::vector<float>(5, 0.2F));
    ASSERT_EQ(after.colors.size(), after.vertices.size());
    for (std::size_t i = 0; i < after.vertices.size(); ++i) {
        EXPECT_NEAR(after.sigma_m[i], 0.01F * after.vertices[i].x(), 1e-6F);
        EXPECT_NEAR(after.colors[i][0], 200.0F * after.vertices[i].x(), 4.0F);  // rounded each time
        EXPECT_EQ(after.normals[i], Eigen::Vector3f::UnitZ());
    }
}

TEST(SplitLongEdgesTest, EdgesAreShortWhereTheLimitIs) {
    std::vector<float> limits(5, 10.0F);
    limits[3] = 0.1F;
    const types::Mesh after = split_long_edges(floor(), limits);
    EXPECT_GT(after.triangles.size(), 5U);
    EXPECT_NE(
        std::find(
            after.triangles.begin(), after.triangles.end(), std::array<std::uint32_t, 3>{1, 4, 2}),
        after.triangles.end())
        << "far from the limit";
}

TEST(SplitLongEdgesTest, ShortEdgesStay) {
    const types::Mesh before = floor();
    EXPECT_EQ(split_long_edges(before, std::vector<float>(5, 2.0F)).triangles, before.triangles);
    EXPECT_TRUE(split_long_edges({}, {}).triangles.empty());
}

}  // namespace
}  // namespace divemesh::mesh
