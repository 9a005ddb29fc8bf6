#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/dive/dive.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

// The cells of a surface, to test whether a point is near it.
class SurfaceCells {
public:
    SurfaceCells(const types::Mesh& mesh, double cell_m) : cell_m_(cell_m) {
        for (const Eigen::Vector3f& vertex : mesh.vertices)
            cells_.insert(cell(vertex.cast<double>()));
    }
    // Returns true if the point is within one cell of the surface.
    bool reach(const Eigen::Vector3d& p_world) const {
        const Cell at = cell(p_world);
        for (int i = 0; i < 27; ++i)
            if (cells_.contains({at[0] + i % 3 - 1, at[1] + i / 3 % 3 - 1, at[2] + i / 9 - 1}))
                return true;
        return false;
    }

private:
    using Cell = std::array<int, 3>;
    Cell cell(const Eigen::Vector3d& p_world) const {
        const Eigen::Vector3d scaled = (p_world / cell_m_).array().floor();
        return {static_cast<int>(scaled.x()),
                static_cast<int>(scaled.y()),
                static_cast<int>(scaled.z())};
    }

    double cell_m_;
    std::set<Cell> cells_;
};

// Counts of the pixels that show one kind of object: with a depth that goes into the fusion, and in
// front of the scene on a surface of the result.
struct Pixels {
    double num = 0.0;
    double num_with_depth = 0.0;
    double num_in_mesh = 0.0;

    double share_with_depth() const { return num_with_depth / num; }
    double share_in_mesh() const { return num_in_mesh / num; }
};

// A swim of 1.5 m past a barge, with fish and snow; the reconstruction is compared with the
// rendered masks.
class DynamicObjectsTest : public testing::Test {
protected:
    DynamicObjectsTest() {
        simulator::simulate({.scene = simulator::SceneKind::Barge,
                             .out = dive_folder_,
                             .length_m = 1.5,
                             .seed = 3,
                             .truth = true,
                             .width_px = 320,
                             .height_px = 240});
        fs::remove(dive_folder_ / "reference.ply");  // a million samples take too long here
        const auto metrics =
            reconstruct_dive({.dive = dive_folder_,
                              .out = folder_ / "out",
                              .scratch = folder_ / "scratch",
                              .options = make_options("standard", {{"texture", false}})},
                             base::ignore_progress);
        const SurfaceCells surface(io::read_ply(folder_ / "out/mesh.ply"),
                                   metrics.at("mesh").at("voxel_m").get<double>());
        const auto dive = dive::Dive::open(dive_folder_, folder_ / "opened");
        const camera::Rectifier rectifier(dive->rig());
        const keyframes::KeyframeStore store(folder_ / "scratch/keyframes");
        const types::Trajectory path = io::read_trajectory(folder_ / "out/trajectory.tum").poses;
        for (std::size_t i = 0; i < path.size(); ++i)
            if (const auto depth = depth_of(store, static_cast<int>(i)))
                compare(path[i], *depth, rectifier, surface);
    }

    // Returns nullopt if the frame was not fused.
    static std::optional<cv::Mat> depth_of(const keyframes::KeyframeStore& store, int frame_index) {
        try {
            return store.read(frame_index).depth.disparity_px;
        } catch (const Error&) {
            return std::nullopt;
        }
    }

    void compare(const types::StampedPose& pose,
                 const cv::Mat& disparity_px,
                 const camera::Rectifier& rectifier,
                 const SurfaceCells& surface) {
        const auto truth = [&](const std::string& kind) {
            const auto name = std::to_string(pose.timestamp_ns) + ".png";
            return rectifier.rectify_left(cv::imread(
                (dive_folder_ / "truth/cam0" / kind / name).string(), cv::IMREAD_UNCHANGED));
        };
        const cv::Mat fish = truth("fish");
        const cv::Mat snow = truth("snow");
        const cv::Mat scene_mm = truth("depth");
        const types::RectifiedRig& rig = rectifier.rig();
        const Eigen::Isometry3d T_world_cam = pose.T_world_imu * rig.T_imu_cam;
        for (int v = 0; v < disparity_px.rows; ++v) {
            for (int u = 0; u < disparity_px.cols; ++u) {
                Pixels& pixels = fish.at<std::uint8_t>(v, u) > 127   ? fish_
                                 : snow.at<std::uint8_t>(v, u) > 127 ? snow_
                                                                     : scene_;
                ++pixels.num;
                const float seen_px = disparity_px.at<float>(v, u);
                if (seen_px <= 0.0F) continue;
                ++pixels.num_with_depth;
                const double depth_m = rig.depth_m(seen_px);
                if (depth_m > 0.95e-3 * scene_mm.at<std::uint16_t>(v, u)) continue;
                if (surface.reach(T_world_cam * rig.point_cam(u, v, depth_m))) ++pixels.num_in_mesh;
            }
        }
    }

    TemporaryFolder folder_;
    fs::path dive_folder_ = folder_ / "dive";
    Pixels fish_;
    Pixels snow_;
    Pixels scene_;
};

// Objects without a feature, or with one for less than two frames, are left to the fusion: it needs
// several views of a surface, and carves away what others see through.
TEST_F(DynamicObjectsTest, FishAndSnowAreKeptOutOfTheSurface) {
    ASSERT_GT(fish_.num, 1000.0);
    ASSERT_GT(snow_.num, 1000.0);
    EXPECT_LT(fish_.share_with_depth(), 0.5 * scene_.share_with_depth());
    EXPECT_GT(scene_.share_with_depth(), 0.8);
    EXPECT_LT(fish_.share_in_mesh(), 0.01);
    // Pixels of the scene count too where their depth is a few per cent too small.
    EXPECT_LT(snow_.share_in_mesh(), scene_.share_in_mesh());
    EXPECT_LT(scene_.share_in_mesh(), 0.03);
    RecordProperty("fish_with_depth", std::to_string(fish_.share_with_depth()));
    RecordProperty("fish_in_mesh", std::to_string(fish_.share_in_mesh()));
    RecordProperty("snow_with_depth", std::to_string(snow_.share_with_depth()));
    RecordProperty("scene_in_mesh", std::to_string(scene_.share_in_mesh()));
    RecordProperty("snow_in_mesh", std::to_string(snow_.share_in_mesh()));
}

}  // namespace
}  // namespace divemesh::pipeline
