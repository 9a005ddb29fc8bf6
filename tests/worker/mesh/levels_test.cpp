#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>

#include "schemas/error.hpp"
#include "tests/worker/mesh/analytic_field.hpp"
#include "worker/base/hashed_random.hpp"
#include "worker/mesh/marching_cubes.hpp"
#include "worker/mesh/mesh_components.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::mesh {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kVoxel_m = 0.01;
constexpr double kBand_voxels = 3.0;

using Block = fusion::BlockCoordinate;

// How levels are spread over space.
struct Spread {
    std::string name;
    int coarsest;
    AnalyticField::Splits splits;
};

bool by_hash(const Block& block, unsigned seed) {
    return base::hash64(seed + fusion::BlockCoordinateHash{}(block)) % 2 == 0;
}

std::vector<Spread> spreads() {
    return {
        {"AFaceBetweenTwoLevels",
         1,
         [](const Block&, const Eigen::Vector3d& p) { return p.x() < 0.0; }},
        {"AFaceTheOtherWay", 1, [](const Block&, const Eigen::Vector3d& p) { return p.y() > 0.0; }},
        {"AnEdge",
         1,
         [](const Block&, const Eigen::Vector3d& p) { return p.x() < 0.0 && p.z() < 0.0; }},
        {"ACorner", 1, [](const Block&, const Eigen::Vector3d& p) { return p.maxCoeff() < 0.0; }},
        {"AllButACorner",
         1,
         [](const Block&, const Eigen::Vector3d& p) { return p.maxCoeff() > 0.0; }},
        {"Checkers", 1, [](const Block&, const Eigen::Vector3d& p) { return p.prod() > 0.0; }},
        {"ThreeLevelsAlongX",
         2,
         [](const Block& b, const Eigen::Vector3d& p) {
             return p.x() < (b.level == 2 ? 0.1 : -0.1);
         }},
        {"ThreeLevelsByDistance",
         2,
         [](const Block& b, const Eigen::Vector3d& p) {
             return (p - Eigen::Vector3d(0.2, 0.1, 0.1)).norm() < 0.2 * b.level;
         }},
        {"TwoLevelsByHash",
         1,
         [](const Block& b, const Eigen::Vector3d&) { return by_hash(b, 7); }},
        {"ThreeLevelsByHash",
         2,
         [](const Block& b, const Eigen::Vector3d&) { return by_hash(b, 3); }},
        {"FourLevelsByHash",
         3,
         [](const Block& b, const Eigen::Vector3d&) { return by_hash(b, 5); }},
    };
}

// Area of a plane through the fields.
constexpr double kExtent_m2 = 16 * 8 * kVoxel_m * 16 * 8 * kVoxel_m;

AnalyticField make_field(const AnalyticField::Distance& distance,
                         const Spread& spread,
                         double band_voxels = 1e9) {
    return {distance, kVoxel_m, 8 >> spread.coarsest, spread.coarsest, spread.splits, band_voxels};
}

class Levels : public testing::TestWithParam<Spread> {
protected:
    static AnalyticField field(const AnalyticField::Distance& distance, double band_voxels = 1e9) {
        return make_field(distance, GetParam(), band_voxels);
    }
};

int num_levels(const fusion::SignedDistanceField& field) {
    std::set<int> levels;
    for (const Block& block : field.blocks()) levels.insert(block.level);
    return static_cast<int>(levels.size());
}

// Returns the largest distance of a vertex from the surface, in voxels of its level.
double worst_voxels(const types::Mesh& mesh, const AnalyticField::Distance& distance) {
    double worst = 0.0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        worst = std::max(worst,
                         std::abs(distance(mesh.vertices[i].cast<double>())) /
                             static_cast<double>(mesh.voxel_m[i]));
    return worst;
}

void expect_closed_manifold(const MeshTopology& topology, std::int64_t euler_characteristic) {
    EXPECT_EQ(topology.num_border_edges, 0);
    EXPECT_EQ(topology.num_nonmanifold_edges, 0);
    EXPECT_EQ(topology.num_misoriented_edges, 0);
    EXPECT_EQ(topology.euler_characteristic, euler_characteristic);
}

// Returns how many edges are not used as often in one direction as in the other.
int num_unbalanced_edges(const types::Mesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            balance[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    return static_cast<int>(
        std::count_if(balance.begin(), balance.end(), [](const auto& e) { return e.second != 0; }));
}

TEST_P(Levels, ASphereIsClosedAndOfItsAreaAndVolume) {
    const double radius = 0.4;
    const auto ball = sphere({0.013, -0.007, 0.021}, radius);
    for (const double band_voxels : {1e9, kBand_voxels}) {
        const AnalyticField balls = field(ball, band_voxels);
        EXPECT_GT(num_levels(balls), 1);
        const types::Mesh surface = surface_nets(balls, {.num_threads = 2});
        const MeshTopology topology = check_topology(surface);
        expect_closed_manifold(topology, 2);
        EXPECT_NEAR(topology.area_m2 / (4.0 * kPi * radius * radius), 1.0, 0.01);
        EXPECT_NEAR(topology.volume_m3 / (4.0 / 3.0 * kPi * std::pow(radius, 3)), 1.0, 0.01);
        EXPECT_LT(worst_voxels(surface, ball), 0.1);
    }
}

TEST_P(Levels, ATorusHasAHole) {
    const auto torus = [](const Eigen::Vector3d& p) {
        return std::hypot(std::hypot(p.x(), p.y()) - 0.33, p.z() - 0.004) - 0.17;
    };
    for (const double band_voxels : {1e9, kBand_voxels}) {
        const types::Mesh surface = surface_nets(field(torus, band_voxels), {.num_threads = 2});
        const MeshTopology topology = check_topology(surface);
        expect_closed_manifold(topology, 0);
        EXPECT_NEAR(topology.area_m2 / (4.0 * kPi * kPi * 0.33 * 0.17), 1.0, 0.01);
        EXPECT_NEAR(topology.volume_m3 / (2.0 * kPi * kPi * 0.33 * 0.17 * 0.17), 1.0, 0.01);
        EXPECT_LT(worst_voxels(surface, torus), 0.15);
    }
}

// The plate is 1.6 voxels of the coarsest level thick, and crosses all boundaries between levels.
TEST_P(Levels, TheSidesOfAPlateStayApart) {
    const double thick = 1.6 * std::ldexp(kVoxel_m, GetParam().coarsest);
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
    const auto plate = [=](const Eigen::Vector3d& p) {
        const Eigen::Vector3d q = R * p - Eigen::Vector3d(0.004, 0.002, 0.003);
        const Eigen::Array3d past = q.array().abs() - Eigen::Array3d(0.3, 0.3, 0.5 * thick);
        return past.max(0.0).matrix().norm() + std::min(0.0, past.maxCoeff());
    };
    for (const double band_voxels : {1e9, kBand_voxels}) {
        const types::Mesh surface = surface_nets(field(plate, band_voxels), {.num_threads = 2});
        const MeshTopology topology = check_topology(surface);
        expect_closed_manifold(topology, 2);
        EXPECT_EQ(find_components(surface).area_m2.size(), 1U);
    }
}

TEST_P(Levels, ATiltedPlaneIsFlat) {
    const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
    const auto plane = [=](const Eigen::Vector3d& p) { return normal.dot(p) - 0.0123; };
    for (const double band_voxels : {1e9, kBand_voxels}) {
        const types::Mesh surface = surface_nets(field(plane, band_voxels), {.num_threads = 2});
        EXPECT_LT(worst_voxels(surface, plane), 0.05);  // what relaxing in the cell leaves
        EXPECT_EQ(check_topology(surface).num_misoriented_edges, 0);
        EXPECT_EQ(check_topology(surface).euler_characteristic, 1);
        EXPECT_NEAR(check_topology(surface).area_m2, kExtent_m2 / normal.z(), 0.2 * kExtent_m2);
        int num_flipped = 0;
        for (const auto& t : surface.triangles) {
            const Eigen::Vector3f cross =
                (surface.vertices[t[1]] - surface.vertices[t[0]])
                    .cross(surface.vertices[t[2]] - surface.vertices[t[0]]);
            num_flipped += cross.cast<double>().dot(normal) < -1e-9 ? 1 : 0;
        }
        EXPECT_EQ(num_flipped, 0) << "of " << surface.triangles.size();
    }
}

TEST_P(Levels, RandomSignsGiveAClosedOrientedSurface) {
    std::int64_t num_edges = 0, num_nonmanifold = 0;
    for (unsigned seed = 1; seed <= 2; ++seed) {
        const auto noise = [&](const Eigen::Vector3d& p) {
            if (p.cwiseAbs().maxCoeff() > 0.25) return 1.0;
            const Eigen::Vector3i i = (p / kVoxel_m).array().round().cast<int>();
            const std::uint64_t hash = base::hash64(
                seed + base::hash64(i.x() + base::hash64(i.y() + base::hash64(i.z()))));
            return static_cast<double>(hash >> 11) / static_cast<double>(1ULL << 52) - 1.0;
        };
        const types::Mesh surface = surface_nets(field(noise), {.num_threads = 2});
        const MeshTopology topology = check_topology(surface);
        EXPECT_EQ(topology.num_border_edges, 0);
        EXPECT_EQ(topology.num_misoriented_edges, 0);
        EXPECT_EQ(num_unbalanced_edges(surface), 0);
        EXPECT_GT(topology.volume_m3, 0.0);
        num_edges += static_cast<std::int64_t>(surface.triangles.size()) * 3 / 2;
        num_nonmanifold += topology.num_nonmanifold_edges;
    }
    EXPECT_EQ(num_nonmanifold, 0) << "of " << num_edges;
}

TEST_P(Levels, AHoleStaysAHole) {
    const auto disc = [](const Eigen::Vector3d& p) {
        return std::hypot(p.x() - 0.05, p.y()) > 0.2 ? p.z() - 0.003 : std::nan("");
    };
    const types::Mesh surface = surface_nets(field(disc, kBand_voxels), {.num_threads = 2});
    const double area_m2 = check_topology(surface).area_m2;
    EXPECT_EQ(check_topology(surface).euler_characteristic, 0);
    EXPECT_NEAR(area_m2, kExtent_m2 - kPi * 0.2 * 0.2, 0.15 * kExtent_m2);
    for (const auto& vertex : surface.vertices)
        EXPECT_GT(std::hypot(vertex.x() - 0.05F, vertex.y()), 0.2F - 0.01F);
}

TEST_P(Levels, OneThreadAndTwoGiveTheSameBytes) {
    AnalyticField balls = field(sphere({0.0, 0.01, 0.02}, 0.35), kBand_voxels);
    balls.sigma_m = 0.004F;
    const types::Mesh one = surface_nets(balls, {.num_threads = 1});
    const types::Mesh two = surface_nets(balls, {.num_threads = 2});
    ASSERT_GT(one.vertices.size(), 500U);
    EXPECT_EQ(one.vertices, two.vertices);
    EXPECT_EQ(one.normals, two.normals);
    EXPECT_EQ(one.voxel_m, two.voxel_m);
    EXPECT_EQ(one.triangles, two.triangles);
}

INSTANTIATE_TEST_SUITE_P(Spreads, Levels, testing::ValuesIn(spreads()), [](const auto& spread) {
    return spread.param.name;
});

TEST(MarchingCubes, RejectAFieldOfSeveralLevels) {
    EXPECT_THROW(marching_cubes(make_field(sphere({0, 0, 0}, 0.3), spreads().front()), {}), Error);
}

TEST(SurfaceNets, OfACoarserLevelAreThoseOfALargerVoxel) {
    const auto ball = sphere({0.013, -0.007, 0.021}, 0.3);
    const auto never = [](const Block&, const Eigen::Vector3d&) { return false; };
    const types::Mesh coarse = surface_nets(AnalyticField(ball, kVoxel_m, 4, 1, never), {});
    const types::Mesh large = surface_nets(AnalyticField(ball, 2.0 * kVoxel_m, 4), {});
    ASSERT_GT(coarse.vertices.size(), 500U);
    EXPECT_EQ(coarse.vertices, large.vertices);
    EXPECT_EQ(coarse.triangles, large.triangles);
    EXPECT_EQ(coarse.voxel_m, large.voxel_m);
}

}  // namespace
}  // namespace divemesh::mesh
