#include "tests/bench/draw_mesh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::bench {
namespace {

const cv::Vec3b kNoMesh(255, 0, 255);

// A square of 2 m at z = 0 whose texture is red, green, blue and grey in its north west, north
// east, south west and south east.
io::TexturedMesh square() {
    io::TexturedMesh shown;
    shown.mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    shown.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    cv::Mat atlas(128, 128, CV_8UC3);
    atlas(cv::Rect(0, 0, 64, 64)) = cv::Scalar(0, 0, 200);
    atlas(cv::Rect(64, 0, 64, 64)) = cv::Scalar(0, 200, 0);
    atlas(cv::Rect(0, 64, 64, 64)) = cv::Scalar(200, 0, 0);
    atlas(cv::Rect(64, 64, 64, 64)) = cv::Scalar(90, 90, 90);
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", atlas, jpeg, {cv::IMWRITE_JPEG_QUALITY, 100});
    shown.texture.jpegs.emplace_back(jpeg.begin(), jpeg.end());
    shown.texture.atlas_of_triangle = {0, 0};
    const Eigen::Vector2f a(0, 1), b(1, 1), c(1, 0), d(0, 0);
    shown.texture.uv = {{a, b, c}, {a, c, d}};
    return shown;
}

// A camera 2 m above the middle: 100 px to the metre, y of the world up in the image.
Viewpoint above() {
    Viewpoint viewpoint;
    viewpoint.T_world_cam.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
    viewpoint.T_world_cam.translation().z() = 2.0;
    viewpoint.focal_px = 200.0;
    viewpoint.size_px = {240, 240};
    return viewpoint;
}

// JPEG changes colours by a few grey values.
void expect_color(const cv::Mat& image, int row, int column, const cv::Vec3b& truth) {
    EXPECT_LE(cv::norm(image.at<cv::Vec3b>(row, column), truth, cv::NORM_INF), 6.0)
        << row << " " << column << ": " << image.at<cv::Vec3b>(row, column);
}

TEST(DrawMeshTest, TheTextureIsWhereItsTrianglesAre) {
    const cv::Mat image = draw_mesh(square(), above());

    ASSERT_EQ(image.size(), cv::Size(240, 240));
    expect_color(image, 60, 60, {0, 0, 200});
    expect_color(image, 60, 180, {0, 200, 0});
    expect_color(image, 180, 60, {200, 0, 0});
    expect_color(image, 180, 180, {90, 90, 90});
    // The square ends 1 m = 100 px from the middle.
    expect_color(image, 22, 22, {0, 0, 200});
    expect_color(image, 17, 120, kNoMesh);
    expect_color(image, 120, 222, kNoMesh);
}

// From 45 degrees the texture's middle is the square's middle only if it is drawn in perspective:
// the near half takes more of the image than the far one.
TEST(DrawMeshTest, ATiltedTextureIsInPerspective) {
    Viewpoint tilted = above();
    const double half = std::sqrt(0.5);
    tilted.T_world_cam.linear() << 1.0, 0.0, 0.0, 0.0, -half, half, 0.0, -half, -half;
    tilted.T_world_cam.translation() = Eigen::Vector3d(0.0, -2.0 * half, 2.0 * half);

    const cv::Mat image = draw_mesh(square(), tilted);

    expect_color(image, 114, 60, {0, 0, 200});  // just north of the middle
    expect_color(image, 126, 60, {200, 0, 0});  // just south
    expect_color(image, 114, 180, {0, 200, 0});
    expect_color(image, 126, 180, {90, 90, 90});
    // By the pinhole model the north edge is 200 * half / (2 + half) = 52 px above the middle, the
    // south edge 200 * half / (2 - half) = 109 px below.
    expect_color(image, 120 - 49, 120 - 20, {0, 0, 200});
    expect_color(image, 120 - 55, 120 - 20, kNoMesh);
    expect_color(image, 120 + 106, 120 - 20, {200, 0, 0});
    expect_color(image, 120 + 113, 120 - 20, kNoMesh);
}

TEST(DrawMeshTest, WhatIsNearerHidesWhatIsBehindIt) {
    io::TexturedMesh shown = square();
    for (const float x : {-0.5F, 0.5F}) shown.mesh.vertices.emplace_back(x, -0.5F, 0.5F);
    shown.mesh.vertices.emplace_back(0.0F, 0.5F, 0.5F);
    shown.mesh.colors.assign(7, {10, 250, 120});
    shown.mesh.triangles.push_back({4, 5, 6});
    shown.texture.atlas_of_triangle.push_back(types::TextureMap::kUntextured);
    shown.texture.uv.push_back(shown.texture.uv[0]);
    // One half of the square is drawn after it, the other before.
    std::swap(shown.mesh.triangles[0], shown.mesh.triangles[2]);
    std::swap(shown.texture.atlas_of_triangle[0], shown.texture.atlas_of_triangle[2]);

    const cv::Mat image = draw_mesh(shown, above());

    expect_color(image, 130, 120, {120, 250, 10});
    expect_color(image, 60, 60, {0, 0, 200});
}

TEST(DrawMeshTest, AWholeViewHoldsTheMeshAndACloseOneIsFilledByIt) {
    const io::TexturedMesh shown = square();
    const cv::Mat whole = draw_mesh(shown, whole_view(shown.mesh, Eigen::Vector3d::UnitZ()));
    const cv::Mat close = draw_mesh(shown, close_view(shown.mesh, Eigen::Vector3d::UnitZ()));

    cv::Mat is_empty;
    cv::inRange(whole, cv::Scalar(255, 0, 255), cv::Scalar(255, 0, 255), is_empty);
    // A square as high as an image of 4:3 covers three quarters of it.
    EXPECT_NEAR(cv::countNonZero(is_empty) / static_cast<double>(is_empty.total()), 0.25, 0.05);
    cv::inRange(close, cv::Scalar(255, 0, 255), cv::Scalar(255, 0, 255), is_empty);
    EXPECT_LT(cv::countNonZero(is_empty), 0.8 * static_cast<double>(is_empty.total()));
}

TEST(DrawMeshTest, AnAtlasThatIsNoImageIsNamed) {
    io::TexturedMesh shown = square();
    shown.texture.jpegs[0] = "no image";
    EXPECT_THROW(draw_mesh(shown, above()), Error);
}

}  // namespace
}  // namespace divemesh::bench
