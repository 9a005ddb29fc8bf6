#include "worker/mesh/simplify_within.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/worker/mesh/analytic_field.hpp"
#include "worker/mesh/mesh_components.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::mesh {
namespace {

constexpr double kRadius_m = 0.3;
const Eigen::Vector3d kCentre_m(0.013, -0.007, 0.021);

types::Mesh ball() {
    return surface_nets(AnalyticField(sphere(kCentre_m, kRadius_m), 0.01, 6), {});
}

std::vector<float> everywhere(const types::Mesh& mesh, float tolerance_m) {
    return std::vector<float>(mesh.vertices.size(), tolerance_m);
}

TEST(SimplifyWithin, ABallStaysClosedAndWithinItsTolerance) {
    constexpr float kTolerance_m = 0.001F;
    const types::Mesh mesh = ball();
    const types::Mesh fewer =
        simplify_within(mesh, everywhere(mesh, kTolerance_m), 1, base::ignore_progress);
    EXPECT_LT(fewer.triangles.size(), mesh.triangles.size() / 4);
    const MeshTopology topology = check_topology(fewer);
    EXPECT_EQ(topology.num_border_edges, 0);
    EXPECT_EQ(topology.num_nonmanifold_edges, 0);
    EXPECT_EQ(topology.num_misoriented_edges, 0);
    EXPECT_EQ(topology.euler_characteristic, 2);
    // A facet is deepest at its centre.
    std::vector<double> depths_m;
    for (const auto& triangle : fewer.triangles) {
        const Eigen::Vector3f centre = (fewer.vertices[triangle[0]] + fewer.vertices[triangle[1]] +
                                        fewer.vertices[triangle[2]]) /
                                       3.0F;
        depths_m.push_back(kRadius_m - (centre.cast<double>() - kCentre_m).norm());
    }
    std::sort(depths_m.begin(), depths_m.end());
    EXPECT_LT(depths_m[depths_m.size() * 95 / 100], kTolerance_m);
    EXPECT_LT(depths_m.back(), 2.0 * kTolerance_m);
}

TEST(SimplifyWithin, AnAccurateHalfKeepsMoreTrianglesThanAnUncertainOne) {
    const types::Mesh mesh = ball();
    std::vector<float> tolerance_m(mesh.vertices.size());
    for (std::size_t i = 0; i < tolerance_m.size(); ++i)
        tolerance_m[i] = mesh.vertices[i].x() < 0.0F ? 0.0002F : 0.002F;
    const types::Mesh fewer = simplify_within(mesh, tolerance_m, 1, base::ignore_progress);
    const auto num_accurate = std::count_if(
        fewer.vertices.begin(), fewer.vertices.end(), [](const auto& p) { return p.x() < 0.0F; });
    EXPECT_GT(num_accurate, 3 * (std::ssize(fewer.vertices) - num_accurate));
    EXPECT_EQ(check_topology(fewer).num_border_edges, 0);
}

TEST(SimplifyWithin, BorderVerticesStay) {
    types::Mesh mesh = ball();
    std::erase_if(mesh.triangles,
                  [&](const auto& triangle) { return mesh.vertices[triangle[0]].z() > 0.1F; });
    remove_unreferenced_vertices(mesh);
    const types::Mesh fewer =
        simplify_within(mesh, everywhere(mesh, 0.002F), 1, base::ignore_progress);
    EXPECT_LT(fewer.triangles.size(), mesh.triangles.size() / 2);
    EXPECT_EQ(check_topology(fewer).num_border_edges, check_topology(mesh).num_border_edges);
    EXPECT_EQ(check_topology(fewer).euler_characteristic, 1);
}

TEST(SimplifyWithin, NothingChangesWhereTheToleranceIsNotKnown) {
    const types::Mesh mesh = ball();
    for (const float unknown : {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN()})
        EXPECT_EQ(simplify_within(mesh, everywhere(mesh, unknown), 1, base::ignore_progress)
                      .triangles.size(),
                  mesh.triangles.size());
}

TEST(SimplifyWithin, TheResultDoesNotDependOnTheThreads) {
    const types::Mesh mesh = ball();
    const std::vector<float> tolerance_m = everywhere(mesh, 0.0005F);
    const types::Mesh one = simplify_within(mesh, tolerance_m, 1, base::ignore_progress);
    const types::Mesh three = simplify_within(mesh, tolerance_m, 3, base::ignore_progress);
    EXPECT_EQ(one.triangles, three.triangles);
    EXPECT_EQ(one.vertices, three.vertices);
}

TEST(SimplifyWithin, AnEmptyMeshStaysEmpty) {
    EXPECT_TRUE(simplify_within({}, {}, 1, base::ignore_progress).triangles.empty());
}

TEST(SimplifyWithin, ReportsItsProgressAndStopsWhereThatThrows) {
    const types::Mesh mesh = ball();
    std::vector<double> fractions;
    simplify_within(mesh, everywhere(mesh, 0.001F), 2, [&](const Progress& progress) {
        fractions.push_back(progress.fraction);
    });
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    EXPECT_LT(fractions.front(), 0.1);
    EXPECT_GE(fractions.back(), 0.9);
    for (const std::size_t reached : {std::size_t{0}, fractions.size() / 2, fractions.size() - 1}) {
        std::size_t num_reports = 0;
        const auto cancel = [&](const Progress&) {
            if (num_reports++ == reached) throw Error(ErrorCode::Cancelled, "cancelled");
        };
        EXPECT_THROW(simplify_within(mesh, everywhere(mesh, 0.001F), 2, cancel), Error);
    }
}

}  // namespace
}  // namespace divemesh::mesh
