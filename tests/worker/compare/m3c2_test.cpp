#include "worker/compare/m3c2.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/rough_ground.hpp"
#include "worker/mesh/mean_edge.hpp"

namespace divemesh::compare {
namespace {

using synthetic::ground_mesh;
using synthetic::HeightOf;

struct Compared {
    double mean_m = 0.0;
    double within = 0.0;  // share of cores whose error is at most the LoD95
    std::size_t num = 0;
    std::size_t num_unknown = 0;
};

Compared compare(const types::Mesh& a,
                 const types::Mesh& b,
                 const std::function<double(const Eigen::Vector3f&)>& truth_m,
                 M3c2Options options = {}) {
    const PointGrid grid_a(a.vertices, options.cylinder_m);
    const PointGrid grid_b(b.vertices, options.cylinder_m);
    const std::vector<float> unknown;
    const std::vector<float> spacing_a = mesh::vertex_spacing_m(a);
    const std::vector<float> spacing_b = mesh::vertex_spacing_m(b);
    const SurfacePoints points_a{a.vertices, a.normals, unknown, grid_a, spacing_a};
    const SurfacePoints points_b{b.vertices, b.normals, unknown, grid_b, spacing_b};
    const auto distances = m3c2_distances(points_a, points_a, points_b, options, 2);
    Compared result;
    for (std::size_t i = 0; i < distances.size(); ++i) {
        if (a.vertices[i].head<2>().norm() > 0.4F) continue;
        result.num_unknown += !distances[i].known();
        if (!distances[i].known()) continue;
        const double truth = truth_m(a.vertices[i]);
        ++result.num;
        result.mean_m += static_cast<double>(distances[i].distance_m) - truth;
        result.within += std::abs(static_cast<double>(distances[i].distance_m) - truth) <=
                         static_cast<double>(distances[i].lod95_m);
    }
    result.mean_m /= static_cast<double>(result.num);
    result.within /= static_cast<double>(result.num);
    return result;
}

const HeightOf kTilted = [](double x, double y) { return 0.3 * x - 0.2 * y; };

TEST(M3c2, MeasuresTheKnownOffsetOfATiltedPlane) {
    const double slope = std::sqrt(1.0 + 0.3 * 0.3 + 0.2 * 0.2);
    const types::Mesh a = ground_mesh(kTilted, 0.6, 0.6, 0.01, 0.0, 1);
    const types::Mesh b = ground_mesh(
        [](double x, double y) { return kTilted(x, y) + 0.05; }, 0.6, 0.6, 0.01, 0.0, 2);
    const auto result = compare(a, b, [&](const Eigen::Vector3f&) { return 0.05 / slope; });
    EXPECT_GT(result.num, 1000U);
    EXPECT_NEAR(result.mean_m, 0.0, 1e-4);
}

// The ground of either dive, or both, is sampled up to three levels more coarsely than the cylinder
// of 0.05 m was chosen for.
TEST(M3c2, MeasuresTheKnownOffsetOfCoarseGroundInAWiderCylinder) {
    const double slope = std::sqrt(1.0 + 0.3 * 0.3 + 0.2 * 0.2);
    const HeightOf raised = [](double x, double y) { return kTilted(x, y) + 0.05; };
    for (const auto& [step_a_m, step_b_m] :
         {std::pair{0.025, 0.025}, std::pair{0.04, 0.01}, std::pair{0.01, 0.08}}) {
        const types::Mesh a = ground_mesh(kTilted, 0.8, 0.8, step_a_m, 0.0, 1);
        const types::Mesh b = ground_mesh(raised, 0.8, 0.8, step_b_m, 0.0, 2);
        const auto result = compare(a, b, [&](const Eigen::Vector3f&) { return 0.05 / slope; });
        EXPECT_GT(result.num, 100U) << step_a_m;
        EXPECT_EQ(result.num_unknown, 0U) << step_a_m << " and " << step_b_m;
        EXPECT_NEAR(result.mean_m, 0.0, 1e-4) << step_a_m << " and " << step_b_m;
    }
}

TEST(M3c2, LevelOfDetectionHoldsOnCoarseGround) {
    const types::Mesh a = ground_mesh(kTilted, 0.8, 0.8, 0.03, 0.004, 3);
    const types::Mesh b = ground_mesh(kTilted, 0.8, 0.8, 0.04, 0.006, 4);
    const auto result = compare(a, b, [](const Eigen::Vector3f&) { return 0.0; });
    EXPECT_EQ(result.num_unknown, 0U);
    EXPECT_GT(result.within, 0.8);  // about 25 independent cylinders: standard deviation 4.5 %
}

TEST(M3c2, LevelOfDetectionHoldsFor95PercentOfNoisyPlanes) {
    const types::Mesh a = ground_mesh(kTilted, 0.6, 0.6, 0.01, 0.004, 3);
    const types::Mesh b = ground_mesh(kTilted, 0.6, 0.6, 0.01, 0.006, 4);
    const auto result = compare(a, b, [](const Eigen::Vector3f&) { return 0.0; });
    EXPECT_GT(result.within, 0.92);  // about 250 independent cylinders: standard deviation 1.4 %
    EXPECT_LT(result.within, 0.98);
    EXPECT_NEAR(result.mean_m, 0.0, 5e-4);
}

TEST(M3c2, MeasuresTheGrowthOfAHemisphereAlongItsRadius) {
    const auto hemisphere = [](double radius) {
        return [radius](double x, double y) {
            return std::sqrt(std::max(0.0, radius * radius - x * x - y * y));
        };
    };
    const types::Mesh a = ground_mesh(hemisphere(0.5), 0.6, 0.6, 0.006, 0.001, 5);
    const types::Mesh b = ground_mesh(hemisphere(0.53), 0.6, 0.6, 0.006, 0.001, 6);
    M3c2Options options;
    options.normal_scale_m = 0.06F;
    options.cylinder_m = 0.03F;
    const PointGrid grid_a(a.vertices, 0.03F);
    const PointGrid grid_b(b.vertices, 0.03F);
    const auto distances = m3c2_distances({a.vertices, a.normals, a.sigma_m, grid_a},
                                          {a.vertices, a.normals, a.sigma_m, grid_a},
                                          {b.vertices, b.normals, b.sigma_m, grid_b},
                                          options,
                                          2);
    double sum = 0.0;
    double num = 0.0;
    for (std::size_t i = 0; i < distances.size(); ++i) {
        if (!distances[i].known() || a.vertices[i].head<2>().norm() > 0.35F) continue;
        EXPECT_TRUE(distances[i].significant());
        sum += static_cast<double>(distances[i].distance_m);
        num += 1.0;
    }
    EXPECT_NEAR(sum / num, 0.03, 2e-4);
}

TEST(M3c2, TheRegistrationsErrorIsAddedToTheLevelOfDetection) {
    const types::Mesh a = ground_mesh(kTilted, 0.3, 0.3, 0.01, 0.002, 3);
    const PointGrid grid(a.vertices, 0.05F);
    const SurfacePoints points{a.vertices, a.normals, a.sigma_m, grid};
    M3c2Options options;
    const auto without = m3c2_distances(points, points, points, options, 1);
    options.registration95_m = [](const Eigen::Vector3f&, const Eigen::Vector3f&) {
        return 0.007F;
    };
    const auto with = m3c2_distances(points, points, points, options, 2);
    ASSERT_TRUE(without[1860].known());
    EXPECT_NEAR(with[1860].lod95_m - without[1860].lod95_m, 0.007F, 1e-6F);
}

TEST(M3c2, NeighboursWithCorrelatedErrorsCountAsOne) {
    const types::Mesh a = ground_mesh(kTilted, 0.3, 0.3, 0.01, 0.002, 3);
    const PointGrid grid(a.vertices, 0.05F);
    const SurfacePoints points{a.vertices, a.normals, a.sigma_m, grid};
    M3c2Options options;
    options.independent_m = options.cylinder_m;
    const auto distances = m3c2_distances(points, points, points, options, 1);
    EXPECT_GE(distances[1860].lod95_m, 1.96F * 0.002F * std::sqrt(2.0F) * 0.999F);
}

}  // namespace
}  // namespace divemesh::compare
