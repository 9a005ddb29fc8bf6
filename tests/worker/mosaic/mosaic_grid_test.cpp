#include "worker/mosaic/mosaic_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/mosaic/textured_plate.hpp"

namespace divemesh::mosaic {
namespace {

types::Mesh rectangle(float width_m, float height_m) {
    Plates plates;
    plates.add({1, 1}, {1 + width_m, 1 + height_m}, 0.0F, {0, 0, 0});
    return plates.mesh;
}

TEST(MosaicGridTest, CoversTheMeshFromItsNorthWestCorner) {
    const types::RasterGrid grid = mosaic_grid(rectangle(4, 2), 0.03);

    EXPECT_DOUBLE_EQ(grid.corner_x_m, 1.0);
    EXPECT_DOUBLE_EQ(grid.corner_y_m, 3.0);
    EXPECT_DOUBLE_EQ(grid.pixel_m, 0.03);
    EXPECT_EQ(grid.width_px, 134);  // 4 m / 3 cm = 133.3
    EXPECT_EQ(grid.height_px, 67);
}

TEST(MosaicGridTest, TenKilometresGetCoarserPixelsOfTenthsOfAMillimetre) {
    const types::RasterGrid grid = mosaic_grid(rectangle(10'000, 1), 0.001);

    EXPECT_LE(grid.width_px, 32'767);
    EXPECT_NEAR(grid.pixel_m, 10'000.0 / 32'767, 2e-4);
    EXPECT_NEAR(grid.pixel_m * 1e4, std::round(grid.pixel_m * 1e4), 1e-6);
}

TEST(MosaicGridTest, TheNumberOfPixelsIsLimitedToo) {
    const types::RasterGrid grid = mosaic_grid(rectangle(30, 30), 0.001, {.max_pixels = 1'000'000});

    EXPECT_LE(std::int64_t{grid.width_px} * grid.height_px, 1'000'000);
    EXPECT_NEAR(grid.pixel_m, 0.03, 2e-4);
}

TEST(MosaicGridTest, AnEmptyMeshHasOnePixel) {
    const types::RasterGrid grid = mosaic_grid({}, 0.001);

    EXPECT_EQ(grid.width_px, 1);
    EXPECT_EQ(grid.height_px, 1);
}

}  // namespace
}  // namespace divemesh::mosaic
