#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <random>
#include <string>

#include "tests/worker/mesh/analytic_field.hpp"
#include "worker/mesh/marching_cubes.hpp"
#include "worker/mesh/mesh_components.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::mesh {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kVoxel_m = 0.01;

class BothMeshers : public testing::TestWithParam<std::string> {
protected:
    static types::Mesh mesh(const fusion::SignedDistanceField& field, int num_threads = 1) {
        MeshingSettings settings;
        settings.num_threads = num_threads;
        return GetParam() == "surface_nets" ? surface_nets(field, settings)
                                            : marching_cubes(field, settings);
    }
};

void expect_closed_manifold(const types::Mesh& mesh, std::int64_t euler_characteristic) {
    const MeshTopology topology = check_topology(mesh);
    EXPECT_EQ(topology.num_border_edges, 0);
    EXPECT_EQ(topology.num_nonmanifold_edges, 0);
    EXPECT_EQ(topology.num_misoriented_edges, 0);
    EXPECT_EQ(topology.euler_characteristic, euler_characteristic);
}

TEST_P(BothMeshers, ASphereAcrossBlocksIsClosedOrientedAndOfItsAreaAndVolume) {
    const Eigen::Vector3d center(0.013, -0.007, 0.021);
    const double radius = 0.15;
    const types::Mesh surface = mesh(AnalyticField(sphere(center, radius), kVoxel_m, 3));
    expect_closed_manifold(surface, 2);
    const MeshTopology topology = check_topology(surface);
    EXPECT_NEAR(topology.area_m2 / (4.0 * kPi * radius * radius), 1.0, 0.005);
    EXPECT_NEAR(topology.volume_m3 / (4.0 / 3.0 * kPi * std::pow(radius, 3)), 1.0, 0.005);
    for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
        const Eigen::Vector3d out = surface.vertices[i].cast<double>() - center;
        EXPECT_NEAR(out.norm(), radius, 0.03 * kVoxel_m);
        EXPECT_GT(surface.normals[i].cast<double>().dot(out.normalized()), 0.99);
    }
}

TEST_P(BothMeshers, TwoSpheresAreTwoComponents) {
    const auto a = sphere({-0.1, 0.0, 0.0}, 0.06), b = sphere({0.1, 0.01, 0.0}, 0.05);
    const types::Mesh surface = mesh(
        AnalyticField([=](const Eigen::Vector3d& p) { return std::min(a(p), b(p)); }, kVoxel_m, 3));
    EXPECT_EQ(find_components(surface).area_m2.size(), 2U);
    expect_closed_manifold(surface, 4);
    const LargeComponents large = keep_large_components(surface, 400.0);
    EXPECT_EQ(find_components(large.mesh).area_m2.size(), 1U);
    EXPECT_NEAR(large.removed_m2 / (4.0 * kPi * 0.05 * 0.05), 1.0, 0.03);
}

TEST_P(BothMeshers, ATorusHasEulerNumberZero) {
    const auto torus = [](const Eigen::Vector3d& p) {
        return std::hypot(std::hypot(p.x(), p.y()) - 0.12, p.z() - 0.004) - 0.05;
    };
    const types::Mesh surface = mesh(AnalyticField(torus, kVoxel_m, 3));
    expect_closed_manifold(surface, 0);
    EXPECT_NEAR(
        check_topology(surface).volume_m3 / (2.0 * kPi * kPi * 0.12 * 0.05 * 0.05), 1.0, 0.02);
}

TEST_P(BothMeshers, ATiltedPlaneIsFlatAndFacesThePositiveSide) {
    const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
    const types::Mesh surface = mesh(AnalyticField(
        [=](const Eigen::Vector3d& p) { return normal.dot(p) - 0.0123; }, kVoxel_m, 2));
    ASSERT_GT(surface.triangles.size(), 500U);
    EXPECT_EQ(check_topology(surface).num_misoriented_edges, 0);
    for (const auto& vertex : surface.vertices)
        EXPECT_NEAR(normal.dot(vertex.cast<double>()), 0.0123, 0.01 * kVoxel_m);
    for (const auto& t : surface.triangles) {
        const Eigen::Vector3f cross = (surface.vertices[t[1]] - surface.vertices[t[0]])
                                          .cross(surface.vertices[t[2]] - surface.vertices[t[0]]);
        EXPECT_GE(cross.cast<double>().dot(normal), -1e-9);
    }
}

// Random signs cover all configurations of all pairs of neighbouring cells. Enclosed by positive
// samples, the mesh must be a manifold for all of them.
TEST_P(BothMeshers, RandomSignsGiveAClosedOrientedManifold) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
        std::mt19937 random(seed);
        std::vector<double> values(32 * 32 * 32);
        for (double& value : values) value = std::uniform_real_distribution<>(-1.0, 1.0)(random);
        const auto noise = [&](const Eigen::Vector3d& p) {
            const Eigen::Vector3i i = (p / kVoxel_m).array().round().cast<int>() + 16;
            if (i.minCoeff() <= 0 || i.maxCoeff() >= 31) return 1.0;
            return values[(i.z() * 32 + i.y()) * 32 + i.x()];
        };
        const types::Mesh surface = mesh(AnalyticField(noise, kVoxel_m, 2));
        const MeshTopology topology = check_topology(surface);
        EXPECT_EQ(topology.num_border_edges, 0);
        EXPECT_EQ(topology.num_nonmanifold_edges, 0);
        EXPECT_EQ(topology.num_misoriented_edges, 0);
        EXPECT_GT(topology.volume_m3, 0.0);
    }
}

TEST_P(BothMeshers, LeaveAHoleWhereTheFieldIsUnknown) {
    const auto disc = [](const Eigen::Vector3d& p) {
        return std::hypot(p.x(), p.y()) < 0.1 ? p.z() - 0.003 : std::nan("");
    };
    const types::Mesh surface = mesh(AnalyticField(disc, kVoxel_m, 3));
    EXPECT_GT(check_topology(surface).num_border_edges, 20);
    EXPECT_NEAR(check_topology(surface).area_m2, kPi * 0.1 * 0.1, 0.3 * kPi * 0.1 * 0.1);
    for (const auto& vertex : surface.vertices) EXPECT_LT(vertex.head<2>().norm(), 0.1F);
}

TEST_P(BothMeshers, OneThreadAndTwoGiveTheSameBytes) {
    const AnalyticField field(sphere({0.0, 0.01, 0.02}, 0.14), kVoxel_m, 3);
    const types::Mesh one = mesh(field, 1);
    const types::Mesh two = mesh(field, 2);
    ASSERT_GT(one.vertices.size(), 500U);
    EXPECT_EQ(one.vertices, two.vertices);
    EXPECT_EQ(one.normals, two.normals);
    EXPECT_EQ(one.triangles, two.triangles);
}

INSTANTIATE_TEST_SUITE_P(Meshers,
                         BothMeshers,
                         testing::Values("surface_nets", "marching_cubes"),
                         [](const auto& mesher) { return mesher.param; });

// Noise with the field's own standard deviation is smoothed, and a vertex never leaves its cell.
TEST(SurfaceNets, RelaxWithinTheNoiseOfTheField) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0.0, 0.15 * kVoxel_m);
    std::vector<double> values(48 * 48 * 48);
    for (double& value : values) value = noise(random);
    const auto rough = [&](const Eigen::Vector3d& p) {
        const Eigen::Vector3i i = (p / kVoxel_m).array().round().cast<int>() + 24;
        return p.z() - 0.004 + values[(i.z() * 48 + i.y()) * 48 + i.x()];
    };
    AnalyticField field(rough, kVoxel_m, 3);
    const auto rms = [&] {
        const types::Mesh surface = surface_nets(field, {.num_threads = 1});
        double sum = 0.0;
        for (const auto& vertex : surface.vertices) sum += std::pow(vertex.z() - 0.004, 2);
        return std::sqrt(sum / static_cast<double>(surface.vertices.size()));
    };
    const double trusted = rms();
    field.sigma_m = 0.0015F;
    const double elastic = rms();
    EXPECT_LT(elastic, 0.85 * trusted);
}

}  // namespace
}  // namespace divemesh::mesh
