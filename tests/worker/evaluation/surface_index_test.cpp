#include "worker/evaluation/surface_index.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace divemesh::evaluation {
namespace {

// A grid of points 0.1 m apart with heights of up to 0.3 m, two triangles to each square.
types::Mesh rough_bed(std::uint32_t side) {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> height_m(0.0F, 0.3F);
    types::Mesh mesh;
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x)
            mesh.vertices.emplace_back(
                0.1F * static_cast<float>(x), 0.1F * static_cast<float>(y), height_m(random));
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x;
            mesh.triangles.push_back({a, a + 1, a + side});
            mesh.triangles.push_back({a + 1, a + side + 1, a + side});
        }
    return mesh;
}

double distance_by_trying_all(const types::Mesh& mesh, const Eigen::Vector3f& point) {
    float least = std::numeric_limits<float>::infinity();
    for (const auto& [a, b, c] : mesh.triangles)
        least = std::min(least,
                         squared_distance_to_triangle(
                             point, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]));
    return static_cast<double>(std::sqrt(least));
}

TEST(SurfaceIndexTest, DistancesOfPointsThatLieAnywhereAreThoseToTheNearestTriangle) {
    const types::Mesh bed = rough_bed(20);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> along(-3.0F, 5.0F);
    std::normal_distribution<float> step(0.0F, 0.02F);
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 300; ++i) {
        const bool jumps = i % 3 == 0;
        const Eigen::Vector3f moved(step(random), step(random), step(random));
        points.push_back(jumps ? Eigen::Vector3f(along(random), along(random), along(random))
                               : Eigen::Vector3f(points.back() + moved));
    }

    const std::vector<double> distances_m = SurfaceIndex(bed).distances_m(points, 2);

    ASSERT_EQ(distances_m.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_FLOAT_EQ(static_cast<float>(distances_m[i]),
                        static_cast<float>(distance_by_trying_all(bed, points[i])));
}

TEST(SurfaceIndexTest, WithoutTrianglesEveryDistanceIsInfinite) {
    const types::Mesh empty;
    for (const double distance_m :
         SurfaceIndex(empty).distances_m({Eigen::Vector3f::Zero(), Eigen::Vector3f::Ones()}, 1))
        EXPECT_TRUE(std::isinf(distance_m));
}

}  // namespace
}  // namespace divemesh::evaluation
