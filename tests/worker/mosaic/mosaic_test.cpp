#include "worker/mosaic/mosaic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/temporary_folder.hpp"

namespace divemesh::mosaic {
namespace {

void add_rectangle(
    types::Mesh& mesh, Eigen::Vector2f low, Eigen::Vector2f high, float z, types::Color color) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(),
                         {{low.x(), low.y(), z},
                          {high.x(), low.y(), z},
                          {high.x(), high.y(), z},
                          {low.x(), high.y(), z}});
    mesh.colors.insert(mesh.colors.end(), 4, color);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
}

// Returns a blue floor of 4 x 2 m with a red plate of 1 x 1 m half a metre above its north-west
// corner.
types::Mesh floor_with_plate() {
    types::Mesh mesh;
    add_rectangle(mesh, {1, 1}, {5, 3}, 0.0F, {0, 0, 200});
    add_rectangle(mesh, {1, 2}, {2, 3}, 0.5F, {200, 0, 0});
    return mesh;
}

MosaicOptions pixels_of(double pixel_m) {
    MosaicOptions options;
    options.pixel_m = pixel_m;
    return options;
}

TEST(Mosaic, NorthIsUpAndTheHighestSurfaceIsSeen) {
    const Mosaic mosaic = render_mosaic(floor_with_plate(), pixels_of(0.1));
    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(5, 5), cv::Vec4b(0, 0, 200, 255));   // B G R A: the plate
    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(15, 5), cv::Vec4b(200, 0, 0, 255));  // south of it
    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(5, 15), cv::Vec4b(200, 0, 0, 255));  // east of it
    EXPECT_FLOAT_EQ(mosaic.height_m.at<float>(5, 5), 0.5F);
    EXPECT_FLOAT_EQ(mosaic.height_m.at<float>(15, 5), 0.0F);
}

TEST(Mosaic, PixelsFindTheirPlaceInTheWorld) {
    const Mosaic mosaic = render_mosaic(floor_with_plate(), pixels_of(0.1));
    EXPECT_DOUBLE_EQ(mosaic.corner_x_m, 1.0);
    EXPECT_DOUBLE_EQ(mosaic.corner_y_m, 3.0);
    EXPECT_NEAR(mosaic.color.cols, 41, 1);
    EXPECT_NEAR(mosaic.color.rows, 21, 1);
}

TEST(Mosaic, NoPixelBetweenNeighbouringTrianglesStaysEmpty) {
    const Mosaic mosaic = render_mosaic(floor_with_plate(), pixels_of(0.013));
    ASSERT_GT(std::min(mosaic.color.rows, mosaic.color.cols), 20);
    for (int row = 1; row < mosaic.color.rows - 2; ++row)
        for (int column = 1; column < mosaic.color.cols - 2; ++column)
            ASSERT_EQ(mosaic.color.at<cv::Vec4b>(row, column)[3], 255) << row << " " << column;
}

TEST(Mosaic, AHugeMeshGetsCoarserPixelsAndNotAHugeImage) {
    types::Mesh mesh = floor_with_plate();
    add_rectangle(mesh, {-900, -900}, {900, 900}, -1.0F, {0, 0, 0});
    MosaicOptions options = pixels_of(0.001);
    options.max_side_px = 500;
    const Mosaic mosaic = render_mosaic(mesh, options);
    EXPECT_LE(mosaic.color.cols, 500);
    EXPECT_NEAR(mosaic.pixel_m, 1800.0 / 499.0, 1e-3);
}

TEST(Mosaic, AnEmptyMeshIsOneTransparentPixel) {
    const Mosaic mosaic = render_mosaic({});
    EXPECT_EQ(mosaic.color.size(), cv::Size(1, 1));
    EXPECT_EQ(mosaic.color.at<cv::Vec4b>(0, 0)[3], 0);
}

TEST(Mosaic, TheHeightImageAndItsScaleGiveTheHeightBack) {
    types::Mesh mesh = floor_with_plate();
    add_rectangle(mesh, {7, 1}, {8, 3}, -1.25F, {9, 9, 9});  // leaves a gap from x = 5 to 7
    const TemporaryFolder folder;
    write_mosaic(folder.path(), render_mosaic(mesh, pixels_of(0.1)));
    const auto json = nlohmann::json::parse(std::ifstream(folder / "mosaic.json"));
    const cv::Mat steps = cv::imread((folder / "mosaic_height.png").string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(steps.type(), CV_16U);
    const auto height_m = [&](int row, int column) {
        return json["elevation"]["lowest_m"].get<double>() +
               (steps.at<std::uint16_t>(row, column) - 1) *
                   json["elevation"]["step_m"].get<double>();
    };
    EXPECT_NEAR(height_m(5, 5), 0.5, 1e-4);
    EXPECT_NEAR(height_m(15, 5), 0.0, 1e-4);
    EXPECT_NEAR(height_m(5, 65), -1.25, 1e-4);
    EXPECT_EQ(steps.at<std::uint16_t>(5, 50), 0);  // no surface
    EXPECT_EQ(json["width_px"], steps.cols);
    const cv::Mat color = cv::imread((folder / "mosaic.png").string(), cv::IMREAD_UNCHANGED);
    EXPECT_EQ(color.at<cv::Vec4b>(5, 50)[3], 0);
}

TEST(Mosaic, TheThumbnailIsSmallAndWhiteWhereThereIsNothing) {
    types::Mesh mesh;
    mesh.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}};
    mesh.colors = {{50, 50, 50}, {50, 50, 50}, {50, 50, 50}};
    mesh.triangles = {{0, 1, 2}};
    const std::string png = thumbnail_png(render_mosaic(mesh, pixels_of(0.01)), 100);
    const cv::Mat image = cv::imdecode(std::vector<char>(png.begin(), png.end()), cv::IMREAD_COLOR);
    EXPECT_EQ(std::max(image.cols, image.rows), 100);
    EXPECT_EQ(image.at<cv::Vec3b>(10, 90), cv::Vec3b(255, 255, 255));
    EXPECT_EQ(image.at<cv::Vec3b>(90, 10), cv::Vec3b(50, 50, 50));
}

}  // namespace
}  // namespace divemesh::mosaic
