#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "worker/base/angle.hpp"
#include "worker/camera/range_correction.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/camera/synchronise_pair.hpp"
#include "worker/camera/virtual_camera.hpp"
#include "worker/camera/water_index.hpp"
#include "worker/simulator/camera_sensor.hpp"
#include "worker/simulator/draw_rig.hpp"
#include "worker/simulator/fit_ports.hpp"
#include "worker/simulator/renderer.hpp"
#include "worker/stats/median.hpp"
#include "worker/stereo/match_stereo.hpp"

namespace divemesh::stereo {
namespace {

using types::Port;

constexpr std::size_t kMinPixels = 10'000;  // of a bin
constexpr double kSurvey_m = 1.4;           // the depth for which all pairs are rectified
constexpr std::array<double, 4> kDepths_m = {0.0, 1.0, 1.5, 2.1};  // where bins begin
constexpr std::array<double, 3> kAngles_deg = {0.0, 10.0, 18.0};

struct Bin {
    double depth_m;
    double angle_deg;
    auto operator<=>(const Bin&) const = default;
};
using Errors = std::map<Bin, std::vector<double>>;  // relative, of the depth

// Returns the largest of some values that is not larger than a value.
template <std::size_t kSize>
double begin_of(const std::array<double, kSize>& begins, double value) {
    double begin = begins.front();
    for (const double other : begins)
        if (other <= value) begin = other;
    return begin;
}

// Returns a pose of the body above the bed, looking down and ahead.
Eigen::Isometry3d look_down(double height_m) {
    Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
    T_world_imu.translation() = Eigen::Vector3d(0.3 * height_m, 0.0, height_m);
    T_world_imu.linear() = (Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitY()))
                               .toRotationMatrix();
    return T_world_imu;
}

// Rendered pairs of a plane, z = 0, seen through ports from several heights.
class PortsTest : public testing::Test {
protected:
    static types::Rig rendered_rig(const simulator::SimulatedPorts& ports, double salinity_psu) {
        return simulator::fit_ports(simulator::draw_rig(640, 480, 5),
                                    {.ports = ports, .salinity_psu = salinity_psu});
    }
    // Returns the rig as the pipeline uses it.
    static types::Rig used_rig(types::Rig rig) {
        camera::move_into_water(rig.cam0, rig.T_imu_cam0, 0.0);
        camera::move_into_water(rig.cam1, rig.T_imu_cam1, 0.0);
        return camera::with_reference_depth(rig, kSurvey_m);
    }

    static void render(const types::Rig& rig) {
        const simulator::Scene scene = simulator::make_scene(simulator::SceneKind::Bed, 7, 1, 4.0);
        const simulator::Water water = simulator::make_water(simulator::WaterKind::Clear);
        simulator::Renderer renderer(scene, rig, {.water = water});
        frames_.clear();
        for (const double height_m : kHeights_m) {
            types::StereoFrame& frame = frames_.emplace_back();
            for (const int camera : {0, 1}) {
                const cv::Mat color =
                    simulator::develop(renderer.render(camera, look_down(height_m), 0.0).radiance,
                                       static_cast<std::uint64_t>(camera),
                                       0.0,
                                       {.exposure = water.exposure, .seed = 5});
                cv::cvtColor(color, camera == 0 ? frame.left : frame.right, cv::COLOR_BGR2GRAY);
            }
        }
    }

    // Returns the errors of the depths that pairs show if they are rectified for a rig, with or
    // without the correction by range.
    static Errors errors_of(const types::Rig& rig, bool by_range) {
        const camera::Rectifier rectifier(rig);
        Errors errors;
        for (std::size_t i = 0; i < frames_.size(); ++i) {
            types::RectifiedFrame frame = rectifier.rectify(frames_[i]);
            if (!by_range) frame.ranges.reset();
            types::KeyframeImages images;
            images.depth = StereoMatcher("sgm", 192, 2).match(frame);
            camera::correct_disparities(frame, images.depth);
            if (frame.ranges) images = camera::at_own_range(*frame.ranges, images);
            add(rectifier.rig(), look_down(kHeights_m[i]), images.depth.disparity_px, errors);
        }
        return errors;
    }

    static void add(const types::RectifiedRig& rig,
                    const Eigen::Isometry3d& T_world_imu,
                    const cv::Mat& disparity_px,
                    Errors& errors) {
        const Eigen::Isometry3d T_world_cam = T_world_imu * rig.T_imu_cam;
        for (int v = 0; v < rig.height_px; ++v)
            for (int u = 0; u < rig.width_px; ++u) {
                const float seen_px = disparity_px.at<float>(v, u);
                if (seen_px <= 0.0F) continue;
                const Eigen::Vector3d ray = rig.point_cam(u, v, 1.0);
                const double true_m =
                    -T_world_cam.translation().z() / (T_world_cam.linear() * ray).z();
                const double angle_deg = std::atan(ray.head<2>().norm()) * base::kDegPerRad;
                errors[{begin_of(kDepths_m, true_m), begin_of(kAngles_deg, angle_deg)}].push_back(
                    rig.depth_m(seen_px) / true_m - 1.0);
            }
    }

    // Returns the largest median of a bin whose depths begin within a range; prints all of them.
    static double largest_median(const Errors& errors, double from_m, double to_m) {
        double largest = 0.0;
        int num_bins = 0;
        for (const auto& [bin, values] : errors) {
            if (values.size() < kMinPixels || bin.depth_m < from_m || bin.depth_m >= to_m) continue;
            const double median = stats::median(values);
            std::printf("from %.1f m, %2.0f deg: %+.3f %% of %zu pixels\n",
                        bin.depth_m,
                        bin.angle_deg,
                        100.0 * median,
                        values.size());
            largest = std::max(largest, std::abs(median));
            ++num_bins;
        }
        EXPECT_GE(num_bins, 4);
        return largest;
    }

    static constexpr std::array<double, 4> kHeights_m = {0.7, 1.1, 1.6, 2.3};
    inline static std::vector<types::StereoFrame> frames_;
};

TEST_F(PortsTest, DepthsBehindAFlatPortAreRightAtEveryRangeAndInEveryPartOfTheImage) {
    const simulator::SimulatedPorts far{.distance_m = 0.03, .tilt_deg = 1.0};
    const simulator::SimulatedPorts near{.distance_m = 0.02};
    for (const auto& [ports, salinity_psu] : {std::pair(far, 35.0), std::pair(near, 0.0)}) {
        const types::Rig rig = rendered_rig(ports, salinity_psu);
        render(rig);
        const Errors errors = errors_of(used_rig(rig), true);
        EXPECT_LT(largest_median(errors, 0.0, 1.5), 0.001);
        EXPECT_LT(largest_median(errors, 1.5, 9.0), 0.002);
    }
}

TEST_F(PortsTest, WithoutTheCorrectionByRangeDepthsAreWrong) {
    const types::Rig rig = rendered_rig({.distance_m = 0.03, .tilt_deg = 1.0}, 35.0);
    render(rig);
    EXPECT_GT(largest_median(errors_of(used_rig(rig), false), 0.0, 1.5), 0.002);
}

TEST_F(PortsTest, TheIndexOfAnotherWaterIsNoticed) {
    types::Rig rig = rendered_rig({.distance_m = 0.02}, 0.0);
    render(rig);
    rig.cam0.port->water_index = rig.cam1.port->water_index = camera::water_index(14.0, 35.0);
    EXPECT_GT(largest_median(errors_of(used_rig(rig), true), 0.0, 1.5), 0.003);
}

// The rays of both cameras start elsewhere then, but they keep their directions.
TEST_F(PortsTest, ADistanceThatIsFiveMillimetresOffMattersLittle) {
    types::Rig rig = rendered_rig({.distance_m = 0.025}, 35.0);
    render(rig);
    rig.cam0.port->distance_m = rig.cam1.port->distance_m = 0.03;
    EXPECT_LT(largest_median(errors_of(used_rig(rig), true), 0.0, 9.0), 0.005);
}

TEST_F(PortsTest, DepthsBehindADomeAreRight) {
    const types::Rig rig = rendered_rig({.shape = Port::Shape::Dome, .offset_m = 0.006}, 35.0);
    render(rig);
    const Errors errors = errors_of(used_rig(rig), true);
    EXPECT_LT(largest_median(errors, 0.0, 1.5), 0.001);
    EXPECT_LT(largest_median(errors, 1.5, 9.0), 0.002);
}

}  // namespace
}  // namespace divemesh::stereo
