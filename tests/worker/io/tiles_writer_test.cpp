#include "worker/io/tiles_writer.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <memory>
#include <proj.h>
#include <set>

#include "tests/worker/io/tiles_of_waves.hpp"
#include "worker/io/geographic_frame.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

double plan_area_m2(const types::Mesh& mesh) {
    double twice = 0.0;
    for (const auto& triangle : mesh.triangles) {
        const Eigen::Vector3f a = mesh.vertices[triangle[1]] - mesh.vertices[triangle[0]];
        const Eigen::Vector3f b = mesh.vertices[triangle[2]] - mesh.vertices[triangle[0]];
        twice += static_cast<double>(a.x()) * b.y() - static_cast<double>(a.y()) * b.x();
    }
    return 0.5 * twice;
}

// Returns the root mean square of the distance from the waves, along z, over the triangles'
// centres.
double rms_error_m(const types::Mesh& mesh) {
    double sum = 0.0;
    double area = 0.0;
    for (const auto& triangle : mesh.triangles) {
        types::Mesh one;
        for (const std::uint32_t vertex : triangle) one.vertices.push_back(mesh.vertices[vertex]);
        one.triangles = {{0, 1, 2}};
        const Eigen::Vector3f p = (one.vertices[0] + one.vertices[1] + one.vertices[2]) / 3.0F;
        const double weight = plan_area_m2(one);
        const double error_m = static_cast<double>(p.z()) - height_m(p.x(), p.y());
        sum += weight * error_m * error_m;
        area += weight;
    }
    return std::sqrt(sum / area);
}

class TilesWriterTest : public TilesTest {};

TEST_F(TilesWriterTest, LeavesHaveAllTrianglesAndEveryTileTheAreaOfThoseBelow) {
    write_tiles(file("tiles"),
                waves(),
                nullptr,
                {.position = std::nullopt, .text = "t", .max_triangles = 700});
    const json root = tileset()["root"];
    EXPECT_FALSE(root.contains("transform"));
    std::size_t num_leaf_triangles = 0;
    int num_tiles = 0;
    for_each(root, [&](const json& tile) {
        const types::Mesh mesh = mesh_of(tile);
        ++num_tiles;
        double below_m2 = 0.0;
        for (const json& child : tile.value("children", json::array()))
            below_m2 += plan_area_m2(mesh_of(child));
        if (!tile.contains("children")) {
            num_leaf_triangles += mesh.triangles.size();
            EXPECT_EQ(tile["geometricError"], 0.0);
        } else {
            // A border that moved would change the area seen from above.
            EXPECT_NEAR(plan_area_m2(mesh), below_m2, 2e-4);
        }
    });
    EXPECT_EQ(num_leaf_triangles, 2U * kNumWaveCells * kNumWaveCells);
    EXPECT_EQ(num_tiles, 21);
    EXPECT_LE(mesh_of(root).triangles.size(), 700U);
    EXPECT_NEAR(plan_area_m2(mesh_of(root)), kWaves_m * kWaves_m, 1e-3);
}

TEST_F(TilesWriterTest, ErrorsAreStatedAndBoxesHoldWhatIsBelow) {
    write_tiles(file("tiles"),
                waves(),
                nullptr,
                {.position = std::nullopt, .text = "t", .max_triangles = 700});
    const json whole = tileset();
    EXPECT_EQ(whole["asset"]["version"], "1.1");
    EXPECT_GT(whole["geometricError"], whole["root"]["geometricError"]);
    for_each(whole["root"], [&](const json& tile) {
        EXPECT_EQ(tile["refine"], "REPLACE");
        const types::Mesh mesh = mesh_of(tile);
        EXPECT_LE(rms_error_m(mesh), tile["geometricError"].get<double>() + 1e-3);
        const Eigen::AlignedBox3d box = box_of(tile);
        const Eigen::AlignedBox3d wider(box.min().array() - 1e-4, box.max().array() + 1e-4);
        for (const Eigen::Vector3f& vertex : mesh.vertices)
            EXPECT_TRUE(wider.contains(Eigen::Vector3d(vertex.cast<double>())));
        for (const json& child : tile.value("children", json::array())) {
            EXPECT_LT(child["geometricError"], tile["geometricError"]);
            EXPECT_TRUE(wider.contains(box_of(child)));
        }
    });
}

TEST_F(TilesWriterTest, VerticesOfBordersAreThoseOfTheNeighbourInEveryDetail) {
    write_tiles(file("tiles"),
                waves(),
                nullptr,
                {.position = std::nullopt, .text = "t", .max_triangles = 700});
    const json root = tileset()["root"];
    ASSERT_EQ(root["children"].size(), 4U);
    const types::Mesh coarse = mesh_of(root["children"][0]);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& triangle : coarse.triangles)
        for (std::size_t i = 0; i < 3; ++i)
            ++edges[std::minmax(triangle[i], triangle[(i + 1) % 3])];
    std::set<std::uint32_t> border;
    for (const auto& [edge, count] : edges)
        if (count == 1) border.insert({edge.first, edge.second});
    EXPECT_EQ(border.size(), 4U * kNumWaveCells / 2);  // none was removed
    const double step_m = kWaves_m / kNumWaveCells;
    for (const std::uint32_t vertex : border)
        for (const int axis : {0, 1}) {
            const double steps = static_cast<double>(coarse.vertices[vertex][axis]) / step_m;
            EXPECT_NEAR(steps, std::round(steps), 1e-3);
        }
}

TEST_F(TilesWriterTest, APositionPlacesTheTilesOnTheEarthAsProjDoes) {
    const types::GeographicPosition position{-33.5, 151.25, 90.0};
    write_tiles(file("tiles"), tetrahedron(), nullptr, {.position = position, .text = "t"});
    const auto values = tileset()["root"]["transform"].get<std::array<double, 16>>();
    const Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix4d>(values.data());
    const std::unique_ptr<PJ_CONTEXT, decltype(&proj_context_destroy)> context(
        proj_context_create(), proj_context_destroy);
    const std::unique_ptr<PJ, decltype(&proj_destroy)> cart(
        proj_create(context.get(), "+proj=cart +ellps=WGS84"), proj_destroy);
    constexpr double kRad = 0.017453292519943295;
    const auto place_of = [&](const Eigen::Vector3d& p_world) {
        const Eigen::Vector4d p = T * p_world.homogeneous();
        return proj_trans(cart.get(), PJ_INV, proj_coord(p.x(), p.y(), p.z(), 0));
    };
    const PJ_COORD origin = place_of({0, 0, 5});
    EXPECT_NEAR(origin.lpz.lam, 151.25 * kRad, 1e-12);
    EXPECT_NEAR(origin.lpz.phi, -33.5 * kRad, 1e-12);
    EXPECT_NEAR(origin.lpz.z, 5.0, 1e-6);
    const PJ_COORD east = place_of({10, 0, 0});
    EXPECT_GT(east.lpz.lam, origin.lpz.lam);
    EXPECT_NEAR(east.lpz.phi, origin.lpz.phi, 1e-11);
    const PJ_COORD north = place_of({0, 10, 0});
    EXPECT_GT(north.lpz.phi, origin.lpz.phi);
    EXPECT_NEAR(north.lpz.lam, origin.lpz.lam, 1e-11);
    const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
    EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
}

TEST_F(TilesWriterTest, AMeshWithoutTrianglesIsRefused) {
    types::Mesh points = tetrahedron();
    points.triangles.clear();
    EXPECT_EQ(error_of([&] {
                  write_tiles(
                      file("tiles"), points, nullptr, {.position = std::nullopt, .text = ""});
              }).code(),
              ErrorCode::BadData);
}

}  // namespace
}  // namespace divemesh::io
