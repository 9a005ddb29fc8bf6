#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/worker/reef/sheets.hpp"
#include "worker/reef/area_plane.hpp"
#include "worker/reef/dilate_steps.hpp"
#include "worker/reef/displace_steps.hpp"
#include "worker/reef/fill_gaps.hpp"
#include "worker/reef/heights.hpp"
#include "worker/reef/measure_areas.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

HeightGrid grid_of(const HeightOf& height, int num, double spacing_m) {
    HeightGrid grid;
    grid.shape = {{0.0, 0.0}, spacing_m, num, num};
    for (int row = 0; row < num; ++row)
        for (int column = 0; column < num; ++column)
            grid.heights_m.push_back(height(grid.shape.x_m(column), grid.shape.y_m(row)));
    return grid;
}

bool is_in_hole(double x, double y) { return std::hypot(x - 0.32, y - 0.3) < 0.06; }

TEST(FillGaps, FillsAHoleInAPlaneAlongThePlane) {
    const auto plane = [](double x, double y) { return 0.1 + 0.4 * x - 0.2 * y; };
    const HeightGrid whole = grid_of(plane, 64, 0.01);
    HeightGrid holed = whole;
    for (int row = 0; row < 64; ++row)
        for (int column = 0; column < 64; ++column)
            if (is_in_hole(whole.shape.x_m(column), whole.shape.y_m(row)))
                holed.heights_m[whole.shape.index(column, row)] = kUnseen_m;
    const HeightGrid closed = gaps_filled(holed);
    ASSERT_EQ(closed.heights_m.size(), whole.heights_m.size());
    for (std::size_t i = 0; i < closed.heights_m.size(); ++i) {
        EXPECT_NEAR(closed.heights_m[i], whole.heights_m[i], 0.01);  // the plane rises 0.05 there
        if (holed.heights_m[i] > kUnseen_m) {
            EXPECT_EQ(closed.heights_m[i], holed.heights_m[i]);
        }
    }
}

TEST(FillGaps, FillsAGapAtAStepBetweenTheTwoLevels) {
    HeightGrid step = grid_of([](double x, double) { return x < 0.2 ? 0.3 : 0.0; }, 41, 0.01);
    for (int row = 0; row < 41; ++row)
        for (int column = 20; column < 26; ++column)
            step.heights_m[step.shape.index(column, row)] = kUnseen_m;
    const HeightGrid closed = gaps_filled(step);
    for (int row = 0; row < 41; ++row)
        for (int column = 20; column < 26; ++column) {
            EXPECT_GE(closed.at(column, row), 0.0);
            EXPECT_LE(closed.at(column, row), 0.3);
            EXPECT_LE(closed.at(column, row), closed.at(column - 1, row) + 1e-12);
        }
}

TEST(FillGaps, FillsLowGroundUpToTheFootOfAStep) {
    HeightGrid step = grid_of([](double x, double) { return x < 0.2 ? 0.3 : 0.0; }, 41, 0.01);
    HeightGrid holed = step;
    for (int row = 10; row < 30; ++row)
        for (int column = 20; column < 26; ++column)
            holed.heights_m[step.shape.index(column, row)] = kUnseen_m;
    EXPECT_EQ(gaps_filled_low(holed).heights_m, step.heights_m);
}

TEST(FillGaps, AnUnseenGridStaysUnseen) {
    const HeightGrid dark = grid_of([](double, double) { return kUnseen_m; }, 5, 0.01);
    EXPECT_EQ(gaps_filled(dark).heights_m, dark.heights_m);
}

TEST(DilateSteps, ABlockGrowsOrShrinksByTheDistance) {
    const auto block = [](double x, double y) {
        return x > 0.195 && x < 0.395 && y > 0.195 && y < 0.395 ? 0.5 : 0.0;
    };
    const HeightGrid grid = grid_of(block, 60, 0.01);
    const double volume = volume_over_plane(grid);
    EXPECT_NEAR(volume, 0.2 * 0.2 * 0.5, 1e-9);
    // The cone loses one spacing of height per spacing of distance: 0.49 and 0.48 remain of 0.5.
    const double wider = volume_over_plane(with_steps_dilated(grid, 0.02)) - volume;
    const double corners = std::numbers::pi * 0.02 * 0.02 * 0.485;
    EXPECT_NEAR(wider, 4 * 0.2 * 0.01 * (0.49 + 0.48) + corners, 0.02 * wider);
    const double narrower = volume - volume_over_plane(with_steps_dilated(grid, -0.02));
    EXPECT_NEAR(narrower, (4 * 0.2 - 4 * 0.02) * 0.01 * (0.49 + 0.48), 0.02 * narrower);
}

TEST(DilateSteps, GroundBelow45DegreesStaysUnchanged) {
    const auto slope = [](double x, double y) { return 0.6 * x - 0.3 * y; };
    const HeightGrid grid = grid_of(slope, 40, 0.01);
    for (const double outwards_m : {0.03, -0.03})
        EXPECT_EQ(with_steps_dilated(grid, outwards_m).heights_m, grid.heights_m);
}

// Returns the centre of what rises above the plane, by its heights.
Eigen::Vector2d centre_of(const HeightGrid& grid) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double height = 0.0;
    for (int row = 0; row < grid.shape.num_rows; ++row)
        for (int column = 0; column < grid.shape.num_columns; ++column) {
            sum +=
                grid.at(column, row) * Eigen::Vector2d(grid.shape.x_m(column), grid.shape.y_m(row));
            height += grid.at(column, row);
        }
    return sum / height;
}

// The field is alike over far more than the block, which moves as a whole: by a normal number of
// this deviation along each axis.
TEST(DisplaceSteps, ABlockMovesByTheDeviation) {
    const auto block = [](double x, double y) {
        return x > 0.195 && x < 0.395 && y > 0.195 && y < 0.395 ? 0.5 : 0.0;
    };
    const HeightGrid grid = grid_of(block, 120, 0.005);
    constexpr int kNum = 60;
    double sum_m2 = 0.0;
    for (std::uint64_t seed = 0; seed < kNum; ++seed) {
        const HeightGrid moved = with_steps_displaced(grid, {0.02, 500.0, seed});
        EXPECT_NEAR(volume_over_plane(moved), volume_over_plane(grid), 1e-9);
        sum_m2 += (centre_of(moved) - centre_of(grid)).squaredNorm();
    }
    EXPECT_NEAR(std::sqrt(sum_m2 / (2.0 * kNum)), 0.02, 0.0045);  // 2.5 sigma of 120 numbers
}

TEST(DisplaceSteps, GroundBelow45DegreesStaysUnchanged) {
    const auto slope = [](double x, double y) { return 0.6 * x - 0.3 * y; };
    const HeightGrid grid = grid_of(slope, 40, 0.01);
    EXPECT_EQ(with_steps_displaced(grid, {0.03, 0.05, 7}).heights_m, grid.heights_m);
}

TEST(DisplaceSteps, UnseenNodesStayUnseenAndHideNothing) {
    HeightGrid step = grid_of([](double x, double) { return x < 0.2 ? 0.3 : 0.0; }, 41, 0.01);
    for (int row = 0; row < 41; ++row)
        for (int column = 20; column < 26; ++column)
            step.heights_m[step.shape.index(column, row)] = kUnseen_m;
    const HeightGrid moved = with_steps_displaced(step, {0.02, 0.05, 3});
    for (std::size_t i = 0; i < step.heights_m.size(); ++i)
        EXPECT_EQ(moved.heights_m[i] > kUnseen_m, step.heights_m[i] > kUnseen_m);
}

// Returns blocks of 10 cm on flat ground. Seen from one side, a strip of 3 cm of ground behind each
// block and the block's wall there are missing.
types::Mesh blocks(bool is_seen_from_one_side) {
    types::Mesh mesh;
    const auto floor = [&](double x0, double x1, double y0, double y1) {
        add_face(mesh, {Eigen::Vector3d(x0, y0, 0.0), {x1, y0, 0.0}, {x1, y1, 0.0}, {x0, y1, 0.0}});
    };
    for (int row = 0; row < 5; ++row)
        for (int column = 0; column < 5; ++column) {
            const double x = 0.2 * column;
            const double y = 0.2 * row;
            floor(x, x + 0.2, y, y + 0.045);
            floor(x, x + 0.2, y + 0.145, y + 0.2);
            floor(x, x + 0.045, y + 0.045, y + 0.145);
            floor(x + (is_seen_from_one_side ? 0.175 : 0.145), x + 0.2, y + 0.045, y + 0.145);
            add_face(mesh,
                     {Eigen::Vector3d(x + 0.045, y + 0.045, 0.1),
                      {x + 0.145, y + 0.045, 0.1},
                      {x + 0.145, y + 0.145, 0.1},
                      {x + 0.045, y + 0.145, 0.1}});
        }
    return mesh;
}

json measured(const types::Mesh& mesh) {
    return measure_areas(mesh, {AreaFrame::World, {quadrat("q", 0.0, 1.0)}}, {});
}

TEST(HiddenGround, BehindBlocksIsPartOfTheMetricsOfAnArea) {
    const json truth = measured(blocks(false));
    const json seen = measured(blocks(true));
    EXPECT_NEAR(seen["areas"][1]["coverage"].get<double>(), 0.925, 0.02);
    for (const char* metric : {"rugosity", "volume"}) {
        const double resolution_m = std::string(metric) == "rugosity" ? 0.02 : 0.0;
        const double exact = metric_of(truth, "q", metric, resolution_m)["value"];
        const json entry = metric_of(seen, "q", metric, resolution_m);
        EXPECT_NEAR(entry["value"].get<double>(), exact, 0.25 * exact) << metric;
        EXPECT_LE(entry["low"].get<double>(), exact) << metric;
        EXPECT_GE(entry["high"].get<double>(), exact) << metric;
    }
}

TEST(HiddenGround, FlatGroundThatWasNotSwumOverChangesNothing) {
    const auto waves = [](double x, double) { return 0.02 * std::sin(40.0 * x); };
    const types::Mesh whole = sheet(1.0, 0.01, waves);
    types::Mesh holed = whole;
    holed.triangles.clear();
    for (const auto& triangle : whole.triangles) {
        const Eigen::Vector3f& corner = whole.vertices[triangle[0]];
        if (std::abs(corner.x() - 0.5F) > 0.15F || std::abs(corner.y() - 0.5F) > 0.15F)
            holed.triangles.push_back(triangle);
    }
    const double exact = metric_of(measured(whole), "q", "rugosity", 0.02)["value"];
    const double found = metric_of(measured(holed), "q", "rugosity", 0.02)["value"];
    EXPECT_NEAR(found - 1.0, exact - 1.0, 0.05 * (exact - 1.0));
}

// Returns a sheet of 1 m with square cells, without those of columns and rows [first, end).
types::Mesh holed_sheet(int num_cells, int first, int end, const HeightOf& height) {
    types::Mesh mesh = sheet(1.0, 1.0 / num_cells, height);
    const auto is_hole = [&](int i) { return first <= i && i < end; };
    Triangles seen;
    for (int i = 0; i < std::ssize(mesh.triangles); ++i) {
        const int cell = i / 2;
        if (!is_hole(cell % num_cells) || !is_hole(cell / num_cells))
            seen.push_back(mesh.triangles[i]);
    }
    mesh.triangles = seen;
    return mesh;
}

// Two thirds of the square metre are seen. A slope of one half has 1.118 times its planar area.
TEST(HiddenGround, SurfaceAreaCountsItAndIsNoMoreCertainThanItsRoughness) {
    const double truth_m2 = std::sqrt(1.25);
    const double hidden_m2 = 0.575 * 0.575;
    const json area =
        metric_of(measured(holed_sheet(80, 17, 63, [](double x, double) { return 0.5 * x; })),
                  "q",
                  "surface_area");
    const double value_m2 = area["value"];
    EXPECT_NEAR(value_m2, truth_m2, 0.005 * truth_m2);
    EXPECT_LT(area["low"].get<double>(), truth_m2);
    EXPECT_GT(area["high"].get<double>() - value_m2, 1.9 * hidden_m2 * (truth_m2 - 1.0));
    EXPECT_NE(area["method"].get<std::string>().find("67.3 % of the area was seen"),
              std::string::npos);
}

TEST(HiddenGround, FlatGroundHasItsPlanarAreaHoweverMuchOfItIsSeen) {
    MeasureOptions options;
    options.scale_sigma = 0.0;
    const auto area_of = [&](const types::Mesh& mesh) {
        return metric_of(measure_areas(mesh, {AreaFrame::World, {quadrat("q", 0.0, 1.0)}}, options),
                         "q",
                         "surface_area");
    };
    const auto flat = [](double, double) { return 0.0; };
    const json between_samples = area_of(holed_sheet(80, 17, 63, flat));
    EXPECT_NEAR(between_samples["value"].get<double>(), 1.0, 1e-6);
    const json on_samples = area_of(holed_sheet(64, 16, 48, flat));  // those on its border are seen
    EXPECT_LT(on_samples["low"].get<double>(), 1.0);
    EXPECT_GT(on_samples["high"].get<double>(), 1.0);
    const json whole = area_of(sheet(1.0, 0.0125, flat));
    EXPECT_NEAR(whole["value"].get<double>(), 1.0, 1e-6);
    EXPECT_EQ(whole["high"], whole["value"]);
    EXPECT_EQ(whole["method"].get<std::string>().find("was seen"), std::string::npos);
}

TEST(HiddenGround, ShapeIsThatOfTheGroundSeen) {
    const types::Mesh mesh = holed_sheet(20, 6, 12, [](double x, double y) {
        return -2.0 * (x - 0.5) * (x - 0.5) - 1.0 * (y - 0.5) * (y - 0.5);
    });
    MeasureOptions options;
    options.spacings_m = {0.05};
    const json found = measure_areas(mesh, {AreaFrame::World, {quadrat("q", 0.0, 1.0)}}, options);
    EXPECT_NEAR(metric_of(found, "q", "curvature")["value"].get<double>(), 6.0, 1e-3);
    EXPECT_NEAR(metric_of(found, "q", "curvature_deviation")["value"].get<double>(), 0.0, 1e-2);
}

TEST(HiddenGround, AChainRunsStraightOverIt) {
    types::Mesh mesh = blocks(true);
    Area line;
    line.name = "t";
    line.kind = AreaKind::Transect;
    line.points = {{0.0, 0.1, 0.0}, {1.0, 0.1, 0.0}};
    const json chain =
        metric_of(measure_areas(mesh, {AreaFrame::World, {line}}, {}), "t", "chain_rugosity", 0.01);
    // Up 0.1 m within one link, down 0.1 m over 3 to 4 cm of hidden ground, five times per metre.
    const double up = std::hypot(0.1, 0.01) - 0.01;
    const double down = std::hypot(0.1, 0.035) - 0.035;
    EXPECT_NEAR(chain["value"].get<double>(), 1.0 + 5 * (up + down), 0.02);
    EXPECT_LE(chain["low"].get<double>(), 1.0 + 10 * up);  // of the blocks themselves
    EXPECT_GE(chain["high"].get<double>(), 1.0 + 10 * up);
}

}  // namespace
}  // namespace divemesh::reef
