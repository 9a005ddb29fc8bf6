#include "worker/pipeline/display_mesh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/sea_floor.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::pipeline {
namespace {

using synthetic::SeaFloor;

constexpr float kSigma_m = 0.004F;
constexpr int kNumCells = 40;  // along either side

// A part of the sea floor, 1.6 x 1.2 m, that two keyframes look straight at.
class DisplayMeshTest : public testing::Test {
protected:
    DisplayMeshTest() {
        for (int row = 0; row <= kNumCells; ++row)
            for (int column = 0; column <= kNumCells; ++column)
                floor_.vertices.emplace_back(-0.8F + 1.6F * static_cast<float>(column) / kNumCells,
                                             -0.6F + 1.2F * static_cast<float>(row) / kNumCells,
                                             static_cast<float>(SeaFloor::kDepth_m));
        const std::size_t num = floor_.vertices.size();
        floor_.normals.assign(num, -Eigen::Vector3f::UnitZ());
        floor_.colors.assign(num, {0, 0, 0});
        floor_.sigma_m.assign(num, kSigma_m);
        floor_.num_observations.assign(num, 2);
        for (std::uint32_t row = 0; row < kNumCells; ++row)
            for (std::uint32_t column = 0; column < kNumCells; ++column) {
                const std::uint32_t a = row * (kNumCells + 1) + column;
                const std::uint32_t below = a + kNumCells + 1;
                floor_.triangles.push_back({a, below, a + 1});
                floor_.triangles.push_back({a + 1, below, below + 1});
            }
        for (const int index : {0, 1}) {
            types::Keyframe keyframe;
            keyframe.frame_index = index;
            keyframe.T_world_cam.translation().x() = 0.1 * index;
            keyframes_.push_back(keyframe);
        }
    }
    // `lost_frame` is a frame whose image cannot be read.
    DisplayMesh shown(int lost_frame = -1) const {
        const auto read = [&](int frame_index) {
            if (frame_index == lost_frame) throw Error(ErrorCode::Unavailable, "no disk");
            return SeaFloor()
                .look(keyframes_[static_cast<std::size_t>(frame_index)].T_world_cam)
                .left_color;
        };
        return make_display_mesh(
            floor_, synthetic::small_rig(), keyframes_, read, read, 2, base::ignore_progress);
    }
    // Returns the grey value of the texture at the centre of a triangle.
    static double texel(const types::Texture& texture, std::size_t triangle) {
        const auto& uv = texture.uv[triangle];
        const cv::Mat& atlas =
            texture.atlases[static_cast<std::size_t>(texture.atlas_of_triangle[triangle])];
        const Eigen::Vector2f centre = (uv[0] + uv[1] + uv[2]) / 3.0F;
        cv::Mat patch;
        cv::getRectSubPix(atlas,
                          {1, 1},
                          cv::Point2f(centre.x() * static_cast<float>(atlas.cols) - 0.5F,
                                      centre.y() * static_cast<float>(atlas.rows) - 0.5F),
                          patch);
        return patch.at<cv::Vec3b>(0, 0)[1];
    }

    types::Mesh floor_;
    std::vector<types::Keyframe> keyframes_;
};

TEST_F(DisplayMeshTest, ShowsTheFloorAsThePhotographsDo) {
    const DisplayMesh result = shown();

    EXPECT_EQ(result.metrics.num_atlases, std::ssize(result.texture.atlases));
    EXPECT_TRUE(result.metrics.lost_frames.empty());
    EXPECT_GT(result.metrics.textured_share, 0.999);
    std::vector<double> errors;
    for (std::size_t i = 0; i < result.mesh.triangles.size(); ++i) {
        if (result.texture.atlas_of_triangle[i] == types::Texture::kUntextured) continue;
        Eigen::Vector3f centre = Eigen::Vector3f::Zero();
        for (const std::uint32_t vertex : result.mesh.triangles[i])
            centre += result.mesh.vertices[vertex] / 3.0F;
        const double brightness = SeaFloor().brightness(centre.x(), centre.y());
        errors.push_back(std::abs(texel(result.texture, i) - brightness));
    }
    EXPECT_LT(stats::median(std::move(errors)), 3.0);
}

TEST_F(DisplayMeshTest, NamesTheKeyframeWhoseImageCannotBeRead) {
    const DisplayMesh result = shown(1);

    EXPECT_EQ(result.metrics.lost_frames, std::vector<int>{1});
    EXPECT_GT(result.metrics.textured_share, 0.5);
}

TEST_F(DisplayMeshTest, KeepsWithinHalfASigmaOfTheSurface) {
    const DisplayMesh result = shown();

    EXPECT_LT(result.metrics.num_triangles, std::ssize(floor_.triangles) / 4);
    EXPECT_EQ(result.metrics.num_triangles, std::ssize(result.mesh.triangles));
    EXPECT_LE(result.metrics.simplification.max_m, 0.5 * kSigma_m);
}

}  // namespace
}  // namespace divemesh::pipeline
