#include "worker/mosaic/mosaic_renderer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "tests/worker/mosaic/textured_plate.hpp"
#include "worker/mosaic/mosaic_grid.hpp"

namespace divemesh::mosaic {
namespace {

// Returns a blue floor of 4 x 2 m with a red plate of 1 x 1 m half a metre above its north-west
// corner.
Plates floor_with_plate() {
    Plates plates;
    plates.add({1, 1}, {5, 3}, 0.0F, {0, 0, 200});
    plates.add({1, 2}, {2, 3}, 0.5F, {200, 0, 0});
    return plates;
}

MosaicRows render(const Plates& plates, double pixel_m, int num_threads = 1) {
    const types::RasterGrid grid = mosaic_grid(plates.mesh, pixel_m);
    return MosaicRenderer(plates.mesh, &plates.texture, grid, num_threads).rows(0, grid.height_px);
}

// Returns an atlas whose green is a smooth bump at (column, row), with a `sigma` in texels.
cv::Mat bump(int width, int height, double at_column, double at_row, double sigma) {
    cv::Mat atlas(height, width, CV_8UC3);
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            const double x = (column + 0.5 - at_column) / sigma;
            const double y = (row + 0.5 - at_row) / sigma;
            atlas.at<cv::Vec3b>(row, column) = {
                10, cv::saturate_cast<std::uint8_t>(250.0 * std::exp(-0.5 * (x * x + y * y))), 200};
        }
    return atlas;
}

// Returns the centre of gravity of green, in pixels from the outer corner.
cv::Point2d centre_of_green(const cv::Mat& image) {
    double sum = 0.0;
    cv::Point2d centre;
    for (int row = 0; row < image.rows; ++row)
        for (int column = 0; column < image.cols; ++column) {
            const double weight = image.at<cv::Vec4b>(row, column)[1];
            sum += weight;
            centre += weight * cv::Point2d(column + 0.5, row + 0.5);
        }
    return centre / sum;
}

TEST(MosaicRendererTest, NorthIsUpAndTheHighestSurfaceIsSeen) {
    const MosaicRows mosaic = render(floor_with_plate(), 0.1);

    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(5, 5), cv::Vec4b(0, 0, 200, 255));   // B G R A: the plate
    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(15, 5), cv::Vec4b(200, 0, 0, 255));  // south of it
    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(5, 15), cv::Vec4b(200, 0, 0, 255));  // east of it
    EXPECT_EQ(mosaic.height_m.at<float>(5, 5), 0.5F);
    EXPECT_EQ(mosaic.height_m.at<float>(15, 5), 0.0F);
}

TEST(MosaicRendererTest, NoPixelBetweenNeighbouringTrianglesStaysEmpty) {
    // A fan of thin triangles far from the corner of the mosaic, where numbers are coarse.
    Plates plates;
    plates.add({-3000, -1}, {-2999, 1}, 0.0F, {0, 0, 0});
    const auto first = static_cast<std::uint32_t>(plates.mesh.vertices.size());
    constexpr std::uint32_t kSides = 180;
    plates.mesh.vertices.emplace_back(0.0F, 0.0F, 0.0F);
    for (std::uint32_t i = 0; i < kSides; ++i) {
        const auto angle = static_cast<float>(2.0 * std::numbers::pi * i / kSides);
        plates.mesh.vertices.emplace_back(20 * std::cos(angle), 20 * std::sin(angle), 1.0F);
        plates.mesh.triangles.push_back({first, first + 1 + i, first + 1 + (i + 1) % kSides});
    }
    plates.mesh.colors.resize(plates.mesh.vertices.size());
    plates.texture.uv.resize(plates.mesh.triangles.size());
    plates.texture.atlas_of_triangle.resize(plates.mesh.triangles.size(),
                                            types::Texture::kUntextured);
    const types::RasterGrid grid = mosaic_grid(plates.mesh, 0.1);
    const MosaicRows mosaic = render(plates, 0.1);

    for (int row = 0; row < grid.height_px; ++row)
        for (int column = 0; column < grid.width_px; ++column) {
            const double x_m = grid.corner_x_m + 0.1 * (column + 0.5);
            const double y_m = grid.corner_y_m - 0.1 * (row + 0.5);
            if (std::hypot(x_m, y_m) < 19.9) {
                ASSERT_EQ(mosaic.color.at<cv::Vec4b>(row, column)[3], 255) << row << " " << column;
            }
        }
}

TEST(MosaicRendererTest, APhotographLiesWhereItsTrianglesAre) {
    Plates plates;
    plates.add({1, 1}, {3, 2}, 0.0F, {0, 0, 0});
    plates.paint(bump(400, 200, 290.0, 60.0, 12.0));  // 5 mm a texel: 1.45 m, 0.3 m from the corner

    for (const double pixel_m : {0.002, 0.005, 0.0125}) {
        const cv::Point2d centre = centre_of_green(render(plates, pixel_m).color);
        EXPECT_NEAR(centre.x * pixel_m, 1.45, 0.1 * pixel_m) << pixel_m;
        EXPECT_NEAR(centre.y * pixel_m, 0.30, 0.1 * pixel_m) << pixel_m;
    }
}

TEST(MosaicRendererTest, AtTheSizeOfTexelsThePhotographIsKept) {
    cv::Mat atlas(20, 40, CV_8UC3);
    cv::randu(atlas, 0, 255);
    Plates plates;
    plates.add({0, 0}, {4, 2}, 0.0F, {0, 0, 0});
    plates.paint(atlas);
    const cv::Mat color = render(plates, 0.1).color;

    for (int row = 0; row < 20; ++row)
        for (int column = 0; column < 40; ++column)
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_NEAR(color.at<cv::Vec4b>(row, column)[channel],
                            atlas.at<cv::Vec3b>(row, column)[channel],
                            1);
}

TEST(MosaicRendererTest, APixelOfSeveralTexelsIsTheirMean) {
    cv::Mat atlas(80, 160, CV_8UC3);
    for (int row = 0; row < atlas.rows; ++row)
        for (int column = 0; column < atlas.cols; ++column)
            atlas.at<cv::Vec3b>(row, column) =
                cv::Vec3b::all((row + column) % 2 == 0 ? 40 : 200);  // one texel each
    Plates plates;
    plates.add({0, 0}, {4, 2}, 0.0F, {0, 0, 0});
    plates.paint(atlas);
    const cv::Mat color = render(plates, 0.1).color;  // 4 x 4 texels a pixel

    for (int row = 0; row < 20; ++row)
        for (int column = 0; column < 40; ++column)
            ASSERT_NEAR(color.at<cv::Vec4b>(row, column)[0], 120, 1) << row << " " << column;
}

TEST(MosaicRendererTest, WithoutAPhotographVerticesGiveTheColour) {
    Plates plates;
    plates.add({0, 0}, {1, 1}, 0.0F, {50, 60, 70});
    plates.add({1, 0}, {2, 1}, 0.0F, {9, 9, 9});
    plates.paint(cv::Mat(10, 10, CV_8UC3, cv::Scalar(1, 2, 3)));
    const cv::Mat color = render(plates, 0.1).color;

    EXPECT_EQ(color.at<cv::Vec4b>(5, 4), cv::Vec4b(70, 60, 50, 255));
    EXPECT_EQ(color.at<cv::Vec4b>(5, 14), cv::Vec4b(1, 2, 3, 255));
}

TEST(MosaicRendererTest, HeightAndSigmaAreThoseOfTheSurface) {
    Plates plates;
    plates.add({0, 0}, {4, 2}, -1.0F, {0, 0, 0}, 0.25F);
    plates.mesh.sigma_m = {0.001F, 0.005F, 0.005F, 0.001F};  // grows along x
    plates.add({1, 1}, {2, 2}, 3.0F, {0, 0, 0});             // a step
    plates.mesh.sigma_m.insert(plates.mesh.sigma_m.end(), 4, 0.25F);
    const MosaicRows mosaic = render(plates, 0.01);

    for (int row = 0; row < 200; ++row)
        for (int column = 0; column < 400; ++column) {
            const bool is_step = column >= 100 && column < 200 && row < 100;
            const double x_m = 0.01 * (column + 0.5);
            ASSERT_NEAR(
                mosaic.height_m.at<float>(row, column), is_step ? 3.0 : -1.0 + 0.25 * x_m, 1e-6);
            ASSERT_NEAR(
                mosaic.sigma_m.at<float>(row, column), is_step ? 0.25 : 0.001 + 0.001 * x_m, 1e-7);
        }
}

TEST(MosaicRendererTest, WithoutSurfaceNothingIsKnown) {
    Plates plates;
    plates.add({0, 0}, {1, 1}, 0.0F, {0, 0, 0});
    plates.add({2, 0}, {3, 1}, 0.0F, {0, 0, 0});
    const MosaicRows mosaic = render(plates, 0.1);

    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(5, 15), cv::Vec4b());
    EXPECT_TRUE(std::isnan(mosaic.height_m.at<float>(5, 15)));
    EXPECT_TRUE(std::isnan(mosaic.sigma_m.at<float>(5, 15)));
    EXPECT_TRUE(std::isnan(mosaic.sigma_m.at<float>(5, 5)));  // the mesh has no sigma
}

TEST(MosaicRendererTest, OneTriangleIsEnough) {
    Plates plates;
    plates.add({0, 0}, {1, 1}, 0.0F, {7, 7, 7});
    plates.mesh.triangles.pop_back();
    const MosaicRows mosaic = render(plates, 0.1);

    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(8, 7)[3], 255);
    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(2, 3)[3], 0);
}

TEST(MosaicRendererTest, AnEmptyMeshIsOneTransparentPixel) {
    const MosaicRows mosaic = render({}, 0.1);

    ASSERT_EQ(mosaic.color.size(), cv::Size(1, 1));
    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(0, 0), cv::Vec4b());
}

TEST(MosaicRendererTest, ATriangleOfTenKilometresIsDrawn) {
    Plates plates;
    plates.add({0, 0}, {10'000, 10}, 2.0F, {7, 7, 7});
    const types::RasterGrid grid = mosaic_grid(plates.mesh, 0.001);
    const MosaicRows mosaic = render(plates, 0.001);

    EXPECT_NEAR(grid.width_px * grid.pixel_m, 10'000.0, 1.0);
    for (int column = 0; column < grid.width_px - 1; ++column)
        ASSERT_EQ(mosaic.height_m.at<float>(15, column), 2.0F) << column;
}

bool is_same(const cv::Mat& one, const cv::Mat& other) {
    return one.size() == other.size() &&
           std::equal(one.datastart, one.dataend, other.datastart, other.dataend);
}

TEST(MosaicRendererTest, ThreadsAndTheNumberOfRowsAtOnceDoNotChangeThePixels) {
    Plates plates;
    plates.add({0, 0}, {3, 4}, 0.0F, {9, 9, 9}, 0.3F);
    plates.paint(bump(300, 400, 100, 100, 80));
    plates.add({0.5F, 0.5F}, {2, 3}, 0.2F, {200, 0, 0});
    const types::RasterGrid grid = mosaic_grid(plates.mesh, 0.013);
    const MosaicRows whole = render(plates, 0.013);
    const MosaicRows by_four = render(plates, 0.013, 4);
    EXPECT_TRUE(is_same(whole.color, by_four.color));
    EXPECT_TRUE(is_same(whole.height_m, by_four.height_m));

    const MosaicRenderer renderer(plates.mesh, &plates.texture, grid, 2);
    for (int row = 0; row < grid.height_px; row += 45) {
        const int count = std::min(45, grid.height_px - row);
        const MosaicRows rows = renderer.rows(row, count);
        EXPECT_TRUE(is_same(rows.color, whole.color.rowRange(row, row + count).clone()));
        EXPECT_TRUE(is_same(rows.height_m, whole.height_m.rowRange(row, row + count).clone()));
    }
}

}  // namespace
}  // namespace divemesh::mosaic
