#include "worker/mesh/image_coverage.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>
#include <opencv2/core.hpp>

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

types::DepthMap no_depth(int) { return {}; }

// Returns the depth map of a scene, m, given by column and row.
DepthOfFrame depth_of(const std::function<double(int u, int v)>& scene_m, float sigma_px) {
    types::DepthMap map{cv::Mat(kRig.height_px, kRig.width_px, CV_32F),
                        cv::Mat(kRig.height_px, kRig.width_px, CV_32F, cv::Scalar(sigma_px)),
                        {}};
    for (int v = 0; v < kRig.height_px; ++v)
        for (int u = 0; u < kRig.width_px; ++u)
            map.disparity_px.at<float>(v, u) = static_cast<float>(kRig.disparity_px(scene_m(u, v)));
    return [map](int) { return map; };
}

ImageCoverage coverage(const types::Mesh& mesh,
                       const DepthOfFrame& depth,
                       const CoverageSettings& settings = {}) {
    return image_coverage(mesh, kRig, std::vector<types::Keyframe>(1), depth, settings).at(0);
}

TEST(ImageCoverage, IsTheShareOfTheImageThatTheSurfaceFills) {
    const std::vector<types::Keyframe> keyframes(3);
    const auto images = image_coverage(square(1.0F), kRig, keyframes, no_depth, {});
    ASSERT_EQ(images.size(), 3U);
    // 250 x 250 of 640 x 480 pixels
    EXPECT_NEAR(images[0].covered_share, 250.0 * 250.0 / (640.0 * 480.0), 0.01);
    EXPECT_EQ(images[0].matched_share, 0.0);
    EXPECT_NEAR(mean_covered_share(images), images[0].covered_share, 1e-12);
    EXPECT_FALSE(covered_share_of_matched(images));
    EXPECT_EQ(coverage(square(9.0F), no_depth).covered_share, 1.0);
}

TEST(ImageCoverage, CountsNothingBehindTheCamera) {
    std::vector<types::Keyframe> keyframes(1);
    keyframes[0].T_world_cam.translation().z() = 3.0;
    EXPECT_EQ(image_coverage(square(1.0F), kRig, keyframes, no_depth, {})[0].covered_share, 0.0);
}

// A rib 1 m away fills the right half of the image. The mesh has only the bed 2 m away.
TEST(ImageCoverage, SurfaceBehindWhatTheKeyframeSawDoesNotCoverIt) {
    const auto rib_and_bed = [](int u, int) { return u < 320 ? 2.0 : 1.0; };
    const ImageCoverage image = coverage(square(9.0F), depth_of(rib_and_bed, 0.15F));
    EXPECT_EQ(image.covered_share, 1.0) << "at any depth";
    EXPECT_EQ(image.matched_share, 1.0);
    EXPECT_NEAR(covered_share_of_matched({image}).value(), 0.5, 1e-9);
}

// 0.5 px of disparity are 45 and 51 mm of depth at 2.13 and 2.25 m.
TEST(ImageCoverage, SurfaceCountsWithinThreeSigmaAndTwoVoxels) {
    const CoverageSettings settings{.finest_voxel_m = 0.01, .coarsest_voxel_m = 0.01};
    const auto covered = [&](double depth_m, const CoverageSettings& with) {
        const auto wall = depth_of([&](int, int) { return depth_m; }, 0.5F);
        return coverage(square(9.0F), wall, with).covered_matched_share;
    };
    EXPECT_EQ(covered(2.13, settings), 1.0);
    EXPECT_EQ(covered(2.25, settings), 0.0);
    EXPECT_EQ(covered(2.25, {.mesh_error_m = 0.1}), 1.0);
    const auto wall = depth_of([](int, int) { return 2.25; }, 0.5F);
    EXPECT_FALSE(covered_share_of_matched({coverage(square(9.0F), wall, {.max_depth_m = 2.2})}))
        << "what is farther was not wanted";
}

// The plane z = 2 + x, of two triangles: along a ray its depth is 2 / (1 - x / z).
TEST(ImageCoverage, TheDepthWithinALargeTriangleIsExact) {
    types::Mesh mesh;
    mesh.vertices = {
        {-1.2F, -4.0F, 0.8F}, {3.6F, -4.0F, 5.6F}, {3.6F, 4.0F, 5.6F}, {-1.2F, 4.0F, 0.8F}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    const auto plane = [](int u, int) { return 2.0 / (1.0 - (u - kRig.cx_px) / kRig.focal_px); };
    EXPECT_NEAR(coverage(mesh, depth_of(plane, 0.05F)).covered_matched_share, 1.0, 1e-3);
}

TEST(ImageCoverage, SeesAllPartsOfALargeMeshInAnyDirection) {
    types::Mesh mesh;  // 10 x 10 m in cells of 5 cm, 2 m away
    constexpr std::uint32_t kCells = 200;
    for (std::uint32_t y = 0; y <= kCells; ++y)
        for (std::uint32_t x = 0; x <= kCells; ++x)
            mesh.vertices.emplace_back(
                0.05F * static_cast<float>(x) - 5.0F, 0.05F * static_cast<float>(y) - 5.0F, 2.0F);
    for (std::uint32_t y = 0; y < kCells; ++y)
        for (std::uint32_t x = 0; x < kCells; ++x) {
            const std::uint32_t corner = y * (kCells + 1) + x;
            mesh.triangles.push_back({corner, corner + 1, corner + kCells + 1});
            mesh.triangles.push_back({corner + 1, corner + kCells + 2, corner + kCells + 1});
        }
    for (const double yaw_rad : {-0.5, 0.0, 0.5}) {
        std::vector<types::Keyframe> keyframes(1);
        keyframes[0].T_world_cam.rotate(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()));
        EXPECT_NEAR(
            image_coverage(mesh, kRig, keyframes, no_depth, {})[0].covered_share, 1.0, 1e-3);
    }
}

TEST(ImageCoverage, TakesKeyframesSpreadOverTheDive) {
    std::vector<types::Keyframe> keyframes(100);
    for (int i = 0; i < 100; ++i) keyframes[static_cast<std::size_t>(i)].timestamp_ns = i;
    const CoverageSettings ten{.max_images = 10};
    const auto images = image_coverage(square(1.0F), kRig, keyframes, no_depth, ten);
    ASSERT_EQ(images.size(), 10U);
    EXPECT_EQ(images.front().timestamp_ns, 5);
    EXPECT_EQ(images.back().timestamp_ns, 95);
    EXPECT_TRUE(image_coverage(square(1.0F), kRig, {}, no_depth, ten).empty());
    EXPECT_EQ(mean_covered_share({}), 0.0);
}

}  // namespace
}  // namespace divemesh::mesh
