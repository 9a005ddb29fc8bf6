#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "tests/worker/reef/sheets.hpp"
#include "worker/reef/area_plane.hpp"
#include "worker/reef/heights.hpp"
#include "worker/reef/rugosity.hpp"
#include "worker/reef/surface_patch.hpp"
#include "worker/reef/terrain.hpp"

namespace divemesh::reef {
namespace {

HeightGrid grid_of(const types::Mesh& mesh, const Area& area, double spacing_m) {
    const AreaPlane plane = plane_of(area);
    const SurfacePatch patch = cut_patch(mesh, plane, 0.0);
    return sample_heights(patch.vertices, patch.triangles, grid_over(plane.outline, spacing_m));
}

double mesh_area(const types::Mesh& mesh, const Area& area) {
    const SurfacePatch patch = cut_patch(mesh, plane_of(area), 0.05);
    return surface_area_m2(patch, patch.vertices);
}

void expect_near_share(double value, double truth, double share) {
    EXPECT_NEAR(value, truth, share * std::abs(truth));
}

TEST(ReefMetrics, APlaneHasRugosityOneWhereverItLies) {
    const types::Mesh flat = sheet(1.0, 0.1, [](double, double) { return 0.2; });
    EXPECT_NEAR(rugosity(grid_of(flat, quadrat("q", 0.0, 1.0), 0.05)).value(), 1.0, 1e-9);
    const types::Mesh tilted = sheet(1.0, 0.1, [](double x, double) { return 0.5 * x; });
    Area along = quadrat("q", 0.0, 1.0);
    for (Eigen::Vector3d& corner : along.points) corner.z() = 0.5 * corner.x();
    EXPECT_NEAR(rugosity(grid_of(tilted, along, 0.05)).value(), 1.0, 1e-6);
    // In a horizontal quadrat the surface is longer by its slope.
    expect_near_share(
        rugosity(grid_of(tilted, quadrat("q", 0.0, 1.0), 0.05)).value(), std::sqrt(1.25), 1e-4);
    expect_near_share(mesh_area(tilted, quadrat("q", 0.2, 0.7)), 0.25 * std::sqrt(1.25), 1e-4);
}

// Returns the length of z = a sin(2 pi x / w) over one wave, by Simpson's rule.
double wave_length(double a, double w) {
    constexpr int kNum = 2000;
    double sum = 0.0;
    for (int i = 0; i <= kNum; ++i) {
        const double slope =
            a * 2.0 * std::numbers::pi / w * std::cos(2.0 * std::numbers::pi * i / kNum);
        const double weight = i == 0 || i == kNum ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
        sum += weight * std::hypot(1.0, slope);
    }
    return sum * w / (3.0 * kNum);
}

TEST(ReefMetrics, ASineSheetHasTheAreaOfItsIntegral) {
    const auto height = [](double x, double) {
        return 0.05 * std::sin(2.0 * std::numbers::pi * x / 0.5);
    };
    const types::Mesh mesh = sheet(1.0, 0.005, height);
    const double truth = wave_length(0.05, 0.5) / 0.5;
    expect_near_share(mesh_area(mesh, quadrat("q", 0.0, 1.0)), truth, 1e-3);
    expect_near_share(rugosity(grid_of(mesh, quadrat("q", 0.0, 1.0), 0.01)).value(), truth, 1e-3);
}

TEST(ReefMetrics, AHemisphereAddsItsOwnAreaAndVolume) {
    types::Mesh mesh;
    constexpr int kRings = 200;
    constexpr int kSides = 400;
    const auto at = [&](int ring, int side) {
        const double polar = 0.5 * std::numbers::pi * ring / kRings;
        const double rotation = 2.0 * std::numbers::pi * side / kSides;
        return Eigen::Vector3d(0.5 + 0.3 * std::sin(polar) * std::cos(rotation),
                               0.5 + 0.3 * std::sin(polar) * std::sin(rotation),
                               0.3 * std::cos(polar));
    };
    for (int ring = 0; ring < kRings; ++ring)
        for (int side = 0; side < kSides; ++side)
            add_face(
                mesh,
                {at(ring, side), at(ring + 1, side), at(ring + 1, side + 1), at(ring, side + 1)});
    expect_near_share(mesh_area(mesh, quadrat("q", 0.0, 1.0)), 2.0 * std::numbers::pi * 0.09, 1e-3);
    const HeightGrid grid = grid_of(mesh, quadrat("q", 0.0, 1.0), 0.002);
    expect_near_share(volume_over_plane(grid), 2.0 / 3.0 * std::numbers::pi * 0.027, 1e-3);
    EXPECT_NEAR(height_range(grid).value(), 0.3, 0.01);  // the lowest samples are at the border
}

TEST(ReefMetrics, ABoxOnAPlaneHasItsWalls) {
    types::Mesh mesh = sheet(1.0, 0.1, [](double, double) { return 0.0; });
    add_box(mesh, {0.305, 0.305}, {0.705, 0.705}, 0.2);
    // The plane, also where hidden under the box, the top and four walls.
    expect_near_share(mesh_area(mesh, quadrat("q", 0.0, 1.0)), 1.0 + 0.16 + 4 * 0.4 * 0.2, 1e-3);
    const HeightGrid grid = grid_of(mesh, quadrat("q", 0.0, 1.0), 0.01);
    expect_near_share(volume_over_plane(grid), 0.16 * 0.2, 1e-3);
    // When sampled, a wall leans over one spacing. Where two walls meet, it leans over the cell of
    // a corner, which is cut both ways.
    const double s = 0.01;
    const double walls = 4 * 39 * s * std::hypot(s, 0.2);
    const double corner =
        0.25 * (2.0 * s * std::hypot(s, 0.2) + s * std::sqrt(s * s + 2.0 * 0.04) + s * s);
    const double flat = 1.0 - (4 * 39 + 4) * s * s;
    expect_near_share(grid_area(grid).surface_m2, flat + walls + 4.0 * corner, 1e-3);
}

TEST(ReefMetrics, AConeAndAPyramidHaveTheVolumeAndSlopeOfTheBooks) {
    const types::Mesh cone = sheet(1.0, 0.005, [](double x, double y) {
        return std::max(0.0, 0.2 * (1.0 - std::hypot(x - 0.5, y - 0.5) / 0.4));
    });
    const HeightGrid grid = grid_of(cone, quadrat("q", 0.0, 1.0), 0.005);
    expect_near_share(volume_over_plane(grid), std::numbers::pi * 0.16 * 0.2 / 3.0, 1e-3);
    const double side = std::numbers::pi * 0.4 * std::hypot(0.4, 0.2);
    expect_near_share(
        mesh_area(cone, quadrat("q", 0.0, 1.0)), 1.0 - std::numbers::pi * 0.16 + side, 1e-3);
    types::Mesh pyramid;
    const std::array<Eigen::Vector3d, 4> base = {
        Eigen::Vector3d(0, 0, 0), {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (int i = 0; i < 4; ++i) add_triangle(pyramid, base[i], base[(i + 1) % 4], {0.5, 0.5, 0.3});
    expect_near_share(mesh_area(pyramid, quadrat("q", 0.0, 1.0)), std::hypot(1.0, 0.6), 1e-3);
    expect_near_share(
        volume_over_plane(grid_of(pyramid, quadrat("q", 0.0, 1.0), 0.005)), 0.1, 1e-3);
}

TEST(ReefMetrics, ATiltedPlaneHasItsSlopeNoCurvatureAndNoRuggedness) {
    const types::Mesh mesh = sheet(1.0, 0.1, [](double x, double y) { return 0.3 * x - 0.4 * y; });
    const HeightGrid grid = grid_of(mesh, quadrat("q", 0.0, 1.0), 0.05);
    const Terrain measured = terrain(grid).value();
    EXPECT_NEAR(measured.mean_slope, std::atan(0.5), 1e-6);
    EXPECT_NEAR(measured.mean_curvature, 0.0, 1e-4);
    EXPECT_NEAR(measured.vrm, 0.0, 1e-9);
    EXPECT_TRUE(mean_normal(grid)->isApprox(Eigen::Vector3d(-0.3, 0.4, 1.0).normalized(), 1e-6));
}

TEST(ReefMetrics, AParabolaHasTheCurvatureOfItsSecondDerivatives) {
    const types::Mesh mesh = sheet(1.0, 0.05, [](double x, double y) {
        return -2.0 * (x - 0.5) * (x - 0.5) - 1.0 * (y - 0.5) * (y - 0.5);
    });
    const Terrain measured = terrain(grid_of(mesh, quadrat("q", 0.0, 1.0), 0.05)).value();
    EXPECT_NEAR(measured.mean_curvature, 6.0, 1e-3);
    EXPECT_NEAR(measured.curvature_deviation, 0.0, 1e-2);
}

// Two planes at right angles; the windows that contain the ridge have half of each. The length of
// the sum is worked out by hand.
TEST(ReefMetrics, VrmOfARoofIsThatOfItsNormals) {
    HeightGrid grid{{Eigen::Vector2d::Zero(), 1.0, 5, 5}, {}};
    for (int row = 0; row < 5; ++row)
        for (int column = 0; column < 5; ++column)
            grid.heights_m.push_back(-std::abs(column - 2.0));
    // The three columns of windows have slopes 1, 0, -1: angles 45, 0, 45 degrees.
    const double upward = 6.0 * std::sqrt(0.5) + 3.0;
    EXPECT_NEAR(terrain(grid)->vrm, 1.0 - upward / 9.0, 1e-12);
}

TEST(ReefMetrics, AChainOverARidgeIsAsLongAsItsSides) {
    std::vector<ProfilePoint> profile;
    for (int i = 0; i <= 100; ++i)
        profile.push_back({0.01 * i, 0.3 - std::abs(0.6 * (0.01 * i - 0.5))});
    EXPECT_NEAR(chain_rugosity(profile).value(), std::hypot(1.0, 0.6), 1e-9);
    profile[50].height_m = kUnseen_m;  // two links fewer, both as steep as the others
    EXPECT_NEAR(chain_rugosity(profile).value(), std::hypot(1.0, 0.6), 1e-9);
    EXPECT_FALSE(chain_rugosity({{0.0, 1.0}, {0.1, kUnseen_m}}).has_value());
}

TEST(ReefMetrics, SigmaOfMostOfTheGroundIsByAreaAndNotByVertices) {
    types::Mesh mesh = sheet(1.0, 0.5, [](double, double) { return 0.0; });
    mesh.sigma_m.assign(mesh.vertices.size(), 0.001F);
    for (int i = 0; i < 100; ++i)  // an eighth of all area within the outline
        add_triangle(mesh, {0.5, 0.5, 0.1}, {0.55, 0.5, 0.1}, {0.5, 0.557, 0.1});
    add_triangle(mesh, {1.0, 0.0, 0.1}, {1.04, 9.0, 0.1}, {1.04, -9.0, 0.1});  // beside it
    mesh.sigma_m.resize(mesh.vertices.size(), 0.1F);
    const SurfacePatch patch = cut_patch(mesh, plane_of(quadrat("q", 0.0, 1.0)), 0.05);
    EXPECT_NEAR(sigma_of_most_m(patch, patch.sigma_m).value(), 0.001, 1e-6);
    EXPECT_FALSE(sigma_of_most_m(patch, std::vector<double>(patch.vertices.size())).has_value());
}

TEST(ReefMetrics, TheHighestOfTwoSheetsIsSeen) {
    types::Mesh mesh = sheet(1.0, 0.1, [](double, double) { return 0.0; });
    add_face(mesh,
             {Eigen::Vector3d(0.2, 0.2, 0.5), {0.4, 0.2, 0.5}, {0.4, 0.4, 0.5}, {0.2, 0.4, 0.5}});
    const HeightGrid grid = grid_of(mesh, quadrat("q", 0.0, 1.0), 0.1);
    EXPECT_NEAR(grid.at(3, 3), 0.5, 1e-6);
    EXPECT_NEAR(grid.at(5, 5), 0.0, 1e-6);
    EXPECT_FALSE(grid_of(mesh, quadrat("q", 0.5, 1.5), 0.1).is_seen(8, 8));
}

}  // namespace
}  // namespace divemesh::reef
