// Areas without texture get no depth. The rendered pairs have sensor noise and JPEG blocks, and the
// depth of every pixel is known.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/camera/rectifier.hpp"
#include "worker/simulator/camera_sensor.hpp"
#include "worker/simulator/draw_rig.hpp"
#include "worker/simulator/renderer.hpp"
#include "worker/stereo/match_stereo.hpp"

namespace divemesh::stereo {
namespace {

constexpr float kFarEdge_m = 3.5F;
constexpr int kReach_px = 14;  // of the matcher's windows, with a small margin

// Returns a bed with a boulder; the bed ends 3.5 m ahead, and behind and above it is only water.
simulator::Scene bed_before_open_water() {
    simulator::SceneBuilder builder(3, 1, simulator::place_at({0, 0, 0}));
    builder.add("bed",
                simulator::Material::Coral,
                simulator::make_height_field(
                    {-1.0F, kFarEdge_m, -4.0F, 4.0F}, 0.1F, [](float, float) { return 0.0F; }),
                simulator::place_at({0, 0, 0}));
    builder.add("boulder",
                simulator::Material::Rock,
                simulator::make_ellipsoid({0.3F, 0.3F, 0.4F}, 0.05F),
                simulator::place_at({1.8F, 0.3F, 0.1F}));
    return builder.finish({}, 8.0);
}

// Returns a pose 0.9 m above the bed, looking ahead and slightly down.
Eigen::Isometry3d look_ahead() {
    Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
    T_world_imu.translation() = Eigen::Vector3d(0.0, 0.0, 0.9);
    T_world_imu.linear() = Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitY()).toRotationMatrix();
    return T_world_imu;
}

using ChangeLight = std::function<void(simulator::Rendering& rendering)>;

struct Look {
    types::DepthMap depth;
    cv::Mat open_water;  // CV_8U, 255: only water within the matcher's reach
    cv::Mat surface;     // CV_8U, 255: only the scene within the matcher's reach
};

cv::Mat developed(const simulator::Rendering& rendering,
                  int camera,
                  const simulator::Water& water) {
    const simulator::SensorOptions sensor{.exposure = water.exposure, .seed = 5};
    const cv::Mat color =
        simulator::develop(rendering.radiance, static_cast<std::uint64_t>(camera), 0.0, sensor);
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", color, jpeg, {cv::IMWRITE_JPEG_QUALITY, 93});
    return cv::imdecode(jpeg, cv::IMREAD_GRAYSCALE);
}

Look look(simulator::WaterKind kind, const ChangeLight& change_light, int num_scales) {
    const simulator::Scene scene = bed_before_open_water();
    const types::Rig rig = simulator::draw_rig(640, 480, 4);
    const simulator::Water water = simulator::make_water(kind);
    const auto snow = std::make_shared<simulator::MarineSnow>(200.0, 6);
    simulator::Renderer renderer(scene, rig, {.water = water, .snow = snow, .exact_depth = true});
    types::StereoFrame frame;
    cv::Mat truth;
    for (const int camera : {0, 1}) {
        simulator::Rendering rendering = renderer.render(camera, look_ahead(), 0.0);
        change_light(rendering);
        (camera == 0 ? frame.left : frame.right) = developed(rendering, camera, water);
        if (camera == 0) truth = rendering.depth > 0.0F;
    }
    const camera::Rectifier rectifier(rig);
    const cv::Mat there = rectifier.rectify_left(truth);
    const cv::Mat reach = cv::Mat::ones(2 * kReach_px + 1, 2 * kReach_px + 1, CV_8U);
    Look result;
    cv::dilate(there, result.open_water, reach);
    result.open_water = result.open_water == 0;
    cv::erode(there, result.surface, reach);
    result.surface = result.surface == 255;
    result.depth = StereoMatcher("sgm", 128, num_scales).match(rectifier.rectify(frame));
    return result;
}

double share_known(const types::DepthMap& depth, const cv::Mat& where) {
    const cv::Mat known = depth.disparity_px > 0.0F;
    return static_cast<double>(cv::countNonZero(known & where)) /
           static_cast<double>(cv::countNonZero(where));
}

void leave(simulator::Rendering&) {}

// Makes the whole scene equally bright, so that only vignetting, noise and JPEG blocks are visible.
void without_pattern(simulator::Rendering& rendering) {
    rendering.radiance.setTo(cv::Scalar::all(0.2), rendering.depth > 0.0F);
}

// By the number of scales.
class NoTexture : public testing::TestWithParam<int> {};

TEST_P(NoTexture, SeesTheBedAndNothingInTheOpenWaterBehindIt) {
    for (const simulator::WaterKind kind :
         {simulator::WaterKind::Clear, simulator::WaterKind::Green}) {
        const Look seen = look(kind, leave, GetParam());
        EXPECT_GT(cv::countNonZero(seen.open_water), 30'000);
        EXPECT_LT(share_known(seen.depth, seen.open_water), 0.005) << to_string(kind);
        EXPECT_GT(share_known(seen.depth, seen.surface), 0.7) << to_string(kind);
    }
}

TEST_P(NoTexture, GivesASurfaceWithoutPatternNoDepth) {
    const Look seen = look(simulator::WaterKind::None, without_pattern, GetParam());
    EXPECT_GT(cv::countNonZero(seen.surface), 80'000);
    EXPECT_LT(share_known(seen.depth, seen.surface), 0.005);
}

INSTANTIATE_TEST_SUITE_P(Scales, NoTexture, testing::Values(1, 2));

}  // namespace
}  // namespace divemesh::stereo
