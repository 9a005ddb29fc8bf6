#include "worker/compare/colonies.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace divemesh::compare {
namespace {

reef::Polygon square(double x, double y, double side_m) {
    return {{x, y}, {x + side_m, y}, {x + side_m, y + side_m}, {x, y + side_m}};
}

Colony colony(const std::string& label, const reef::Polygon& outline) {
    return {label, label, outline, reef::area_m2(outline), reef::max_diameter_m(outline), 1.0};
}

TEST(Colonies, TheSameIsTheOneWithTheMostInCommonNeverOneOfAnotherLabel) {
    const std::vector<Colony> before = {colony("Porites", square(0.0, 0.0, 0.2)),
                                        colony("Acropora", square(1.0, 0.0, 0.2))};
    const std::vector<Colony> after = {colony("Porites", square(1.0, 0.0, 0.2)),
                                       colony("Porites", square(0.15, 0.0, 0.2)),
                                       colony("Porites", square(0.01, 0.02, 0.22))};
    const auto pairs = match_colonies(before, after);
    ASSERT_EQ(pairs.size(), 4U);
    EXPECT_EQ(pairs[0].after, 2);
    EXPECT_EQ(pairs[1].after, -1);
    EXPECT_EQ(pairs[2].before, -1);
    EXPECT_EQ(pairs[3].before, -1);
}

TEST(Colonies, OutlinesMayBeHollowAndRunEitherWay) {
    reef::Polygon ell = {{0.0, 0.0}, {0.3, 0.0}, {0.3, 0.1}, {0.1, 0.1}, {0.1, 0.3}, {0.0, 0.3}};
    const std::vector<Colony> in_the_notch = {colony("x", square(0.15, 0.15, 0.2))};
    EXPECT_EQ(match_colonies({colony("x", ell)}, in_the_notch)[0].after, -1);
    EXPECT_EQ(match_colonies(in_the_notch, {colony("x", ell)})[0].after, -1);
    const std::vector<Colony> on_an_arm = {colony("x", square(0.01, 0.15, 0.08))};
    EXPECT_EQ(match_colonies(on_an_arm, {colony("x", ell)})[0].after, 0);
    std::reverse(ell.begin(), ell.end());
    EXPECT_EQ(match_colonies(on_an_arm, {colony("x", ell)})[0].after, 0);
}

TEST(Colonies, OutlinedCellsAreThoseWhoseMiddleIsWithin) {
    const RasterGrid grid{0.1, {-1.0, 2.0}, 40, 30};
    const reef::Polygon triangle = {{0.0, 0.0}, {1.0, 0.03}, {0.31, 0.98}};
    const OutlinedCells within = cells_within(triangle, grid);
    int num = 0;
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column) {
            const cv::Point at(column, row);
            const bool is_in = within.window.contains(at) &&
                               within.cells.at<std::uint8_t>(at - within.window.tl()) != 0;
            EXPECT_EQ(is_in, reef::contains(triangle, grid.center(row, column)))
                << row << " " << column;
            num += is_in ? 1 : 0;
        }
    EXPECT_NEAR(0.01 * num, reef::area_m2(triangle), 0.06);
    EXPECT_TRUE(cells_within(square(5.0, 5.0, 1.0), grid).window.empty());
}

TEST(Colonies, HalfOnTheGroundIsHalf) {
    const RasterGrid grid{0.01, {0.0, 1.0}, 100, 100};
    cv::Mat ground = cv::Mat::zeros(100, 100, CV_8U);
    ground.colRange(0, 50).setTo(cv::Scalar::all(255));
    reef::AreaSet set;
    set.areas.push_back({"c",
                         "x",
                         reef::AreaKind::Outline,
                         {{0.4, 0.4, 0}, {0.6, 0.4, 0}, {0.6, 0.6, 0}, {0.4, 0.6, 0}}});
    set.areas.push_back({"q", "", reef::AreaKind::Quadrat, set.areas[0].points});
    const auto colonies = colonies_of(set, grid, ground);
    ASSERT_EQ(colonies.size(), 1U);
    EXPECT_NEAR(colonies[0].share, 0.5, 1e-9);
    EXPECT_NEAR(colonies[0].area_m2, 0.04, 1e-12);
    EXPECT_NEAR(colonies[0].diameter_m, 0.2 * std::sqrt(2.0), 1e-12);
}

}  // namespace
}  // namespace divemesh::compare
