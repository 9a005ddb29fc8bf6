#include "worker/mesh/image_coverage.hpp"

#include <gtest/gtest.h>

namespace divemesh::mesh {
namespace {

const types::RectifiedRig kRig{.width_px = 640,
                               .height_px = 480,
                               .focal_px = 500.0,
                               .cx_px = 319.5,
                               .cy_px = 239.5,
                               .baseline_m = 0.1};

// Returns a square of `side_m`, 2 m in front of a camera at the origin.
types::Mesh square(float side_m) {
    const float half = 0.5F * side_m;
    types::Mesh mesh;
    mesh.vertices = {
        {-half, -half, 2.0F}, {half, -half, 2.0F}, {half, half, 2.0F}, {-half, half, 2.0F}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

TEST(ImageCoverage, IsTheShareOfTheImageThatTheSurfaceFills) {
    const std::vector<types::Keyframe> keyframes(3);
    const auto images = image_coverage(square(1.0F), kRig, keyframes, 10);
    ASSERT_EQ(images.size(), 3U);
    // 250 x 250 of 640 x 480 pixels
    EXPECT_NEAR(images[0].covered_share, 250.0 * 250.0 / (640.0 * 480.0), 0.01);
    EXPECT_NEAR(mean_covered_share(images), images[0].covered_share, 1e-12);
    EXPECT_EQ(image_coverage(square(9.0F), kRig, keyframes, 10)[0].covered_share, 1.0);
}

TEST(ImageCoverage, CountsNothingBehindTheCamera) {
    std::vector<types::Keyframe> keyframes(1);
    keyframes[0].T_world_cam.translation().z() = 3.0;
    EXPECT_EQ(image_coverage(square(1.0F), kRig, keyframes, 10)[0].covered_share, 0.0);
}

TEST(ImageCoverage, TakesKeyframesSpreadOverTheDive) {
    std::vector<types::Keyframe> keyframes(100);
    for (int i = 0; i < 100; ++i) keyframes[static_cast<std::size_t>(i)].timestamp_ns = i;
    const auto images = image_coverage(square(1.0F), kRig, keyframes, 10);
    ASSERT_EQ(images.size(), 10U);
    EXPECT_EQ(images.front().timestamp_ns, 5);
    EXPECT_EQ(images.back().timestamp_ns, 95);
    EXPECT_TRUE(image_coverage(square(1.0F), kRig, {}, 10).empty());
    EXPECT_EQ(mean_covered_share({}), 0.0);
}

}  // namespace
}  // namespace divemesh::mesh
