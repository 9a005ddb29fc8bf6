// What the options that spoil a dive do to it, against the dive without them and its truth.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/simulator/inertial_sensors.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::simulator {
namespace {

namespace fs = std::filesystem;

// Still, clear water without anything that differs between two dives.
SimulateOptions calm_dive(const fs::path& out) {
    return {.scene = SceneKind::Bed,
            .out = out,
            .length_m = 0.5,
            .rate_hz = 2.0,
            .seed = 5,
            .truth = true,
            .snow = false,
            .fish = false,
            .caustics = false,
            .noise = false,
            .width_px = 96,
            .height_px = 72,
            .png = true};
}

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<fs::path> images_of(const fs::path& folder) {
    std::vector<fs::path> images;
    for (const auto& entry : fs::directory_iterator(folder)) images.push_back(entry.path());
    std::sort(images.begin(), images.end());
    return images;
}

std::vector<fs::path> left_images(const fs::path& dive) {
    return images_of(dive / "mav0/cam0/data");
}

double spread(const fs::path& image) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(cv::imread(image.string()), mean, deviation);
    return deviation[1];
}

double brightness(const fs::path& image) { return cv::mean(cv::imread(image.string()))[1]; }

double share_of_fish(const fs::path& dive) {
    double sum = 0.0;
    const auto masks = images_of(dive / "truth/cam0/fish");
    for (const fs::path& mask : masks)
        sum += cv::mean(cv::imread(mask.string(), cv::IMREAD_GRAYSCALE))[0] / 255.0;
    return sum / static_cast<double>(masks.size());
}

class AlteredDivesTest : public testing::Test {
protected:
    fs::path rendered(const std::string& name, SimulateOptions options) const {
        options.out = folder_ / name;
        simulate(options);
        return options.out;
    }
    std::unique_ptr<dive::Dive> opened(const fs::path& dive) const {
        return dive::Dive::open(dive, folder_ / "scratch");
    }

    TemporaryFolder folder_;
    SimulateOptions calm_ = calm_dive({});
};

TEST_F(AlteredDivesTest, WrongCalibrationIsStatedWhileImagesAndTruthStayThoseOfTheTrueRig) {
    const fs::path exact = rendered("exact", calm_);
    calm_.calibration_error = 1.0;
    const fs::path wrong = rendered("wrong", calm_);
    const auto images = left_images(exact);
    ASSERT_GE(images.size(), 3U);
    for (const fs::path& image : images)
        EXPECT_EQ(content(image), content(wrong / "mav0/cam0/data" / image.filename()));
    const fs::path truth = "mav0/state_groundtruth_estimate0/data.csv";
    ASSERT_FALSE(content(exact / truth).empty());
    EXPECT_EQ(content(exact / truth), content(wrong / truth));
    for (const char* camera : {"cam0", "cam1"}) {
        const std::string stated = content(wrong / "mav0" / camera / "sensor.yaml");
        EXPECT_NE(stated, content(exact / "mav0" / camera / "sensor.yaml"));
        EXPECT_EQ(content(wrong / "truth" / camera / "sensor.yaml"),
                  content(exact / "mav0" / camera / "sensor.yaml"));
    }
    EXPECT_FALSE(fs::exists(exact / "truth/cam0/sensor.yaml"));
}

TEST_F(AlteredDivesTest, MisalignedPairStatesAnotherPitchOfTheRightCamera) {
    const fs::path exact = rendered("exact", calm_);
    calm_.vertical_misalignment_px = 3.0;
    const auto wrong = opened(rendered("wrong", calm_));
    const auto right = opened(exact);
    EXPECT_TRUE(wrong->rig().T_imu_cam0.isApprox(right->rig().T_imu_cam0, 1e-9));
    const Eigen::AngleAxisd pitch(right->rig().T_imu_cam1.linear().transpose() *
                                  wrong->rig().T_imu_cam1.linear());
    EXPECT_NEAR(std::tan(pitch.angle()) * right->rig().cam1.fy_px, 3.0, 1e-3);
    EXPECT_NEAR(std::abs(pitch.axis().x()), 1.0, 1e-6);
}

TEST_F(AlteredDivesTest, TruthAndImuAreAtRestInAPause) {
    calm_.pauses = {{0.0, 2.0}};
    const fs::path folder = rendered("dive", calm_);
    const auto dive = opened(folder);
    const auto& truth = dive->ground_truth();
    ASSERT_FALSE(truth.empty());
    int num_at_rest = 0;
    for (const auto& pose : truth) {
        if (pose.timestamp_ns > kFirstFrame_ns + 2'000'000'000) break;
        EXPECT_TRUE(pose.T_world_imu.isApprox(truth.front().T_world_imu, 1e-9));
        ++num_at_rest;
    }
    EXPECT_GT(num_at_rest, 300);
    EXPECT_FALSE(truth.back().T_world_imu.isApprox(truth.front().T_world_imu, 1e-3));
    // As written: intake leaves out rows that repeat, as a sensor without noise does at rest.
    std::ifstream rows(folder / "mav0/imu0/data.csv");
    std::string row;
    std::getline(rows, row);  // the heading
    int num_samples = 0;      // during the pause
    while (std::getline(rows, row)) {
        std::replace(row.begin(), row.end(), ',', ' ');
        std::istringstream columns(row);
        std::int64_t timestamp_ns = 0;
        Eigen::Vector3d rate, force;
        columns >> timestamp_ns >> rate.x() >> rate.y() >> rate.z() >> force.x() >> force.y() >>
            force.z();
        ASSERT_TRUE(columns) << row;
        if (timestamp_ns > kFirstFrame_ns + 2'000'000'000) break;
        EXPECT_LT(rate.norm(), 1e-9);
        EXPECT_NEAR(force.norm(), kGravity, 1e-6);
        ++num_samples;
    }
    EXPECT_GT(num_samples, 300);
}

TEST_F(AlteredDivesTest, PauseIsNoPartOfTheLength) {
    const auto without = opened(rendered("without", calm_));
    calm_.pauses = {{0.5, 3.0}};
    const auto with = opened(rendered("with", calm_));
    const auto swum = [](const dive::Dive& dive) -> Eigen::Vector3d {
        return dive.ground_truth().back().T_world_imu.translation() -
               dive.ground_truth().front().T_world_imu.translation();
    };
    EXPECT_EQ(with->num_frames() - without->num_frames(), 7);  // 3 s, and a ramp of half a second
    EXPECT_LT((swum(*with) - swum(*without)).norm(), 0.1);
}

TEST_F(AlteredDivesTest, BlueWaterHasNoTexture) {
    calm_.blue_water = {{0.5, 100.0}};
    const fs::path dive = rendered("dive", calm_);
    const auto images = left_images(dive);
    ASSERT_GE(images.size(), 3U);
    EXPECT_GT(spread(images.front()), 8.0);
    // The lens still darkens the corners.
    EXPECT_LT(spread(images.back()), 0.35 * spread(images.front()));
    const auto depths = images_of(dive / "truth/cam0/depth");
    EXPECT_EQ(cv::countNonZero(cv::imread(depths.back().string(), cv::IMREAD_UNCHANGED)), 0);
    EXPECT_GT(cv::countNonZero(cv::imread(depths.front().string(), cv::IMREAD_UNCHANGED)), 1000);
}

TEST_F(AlteredDivesTest, RightCameraThatIsAFrameLateSeesWhatItWouldSeeAFrameLater) {
    const auto in_time = images_of(rendered("in_time", calm_) / "truth/cam1/depth");
    calm_.stereo_offset_ms = 500.0;
    const fs::path late_dive = rendered("late", calm_);
    const auto late = images_of(late_dive / "truth/cam1/depth");
    ASSERT_GE(in_time.size(), 3U);
    ASSERT_GE(late.size(), 3U);
    for (std::size_t i = 0; i + 1 < in_time.size(); ++i)
        EXPECT_EQ(content(late[i]), content(in_time[i + 1]));
    const fs::path left = "truth/cam0/depth";
    EXPECT_EQ(content(late_dive / left / late[1].filename()),
              content(folder_ / "in_time" / left / late[1].filename()));
}

TEST_F(AlteredDivesTest, SandWithoutContrastHasOneTone) {
    const fs::path natural = rendered("natural", calm_);
    calm_.texture_contrast = 0.0;
    const fs::path flat = rendered("flat", calm_);
    EXPECT_GT(spread(images_of(natural / "truth/cam0/albedo").front()), 10.0);
    EXPECT_LT(spread(images_of(flat / "truth/cam0/albedo").front()), 1.0);
}

TEST_F(AlteredDivesTest, MoreFishCoverMoreOfTheImage) {
    calm_.fish = true;
    calm_.length_m = 2.0;
    calm_.rate_hz = 1.0;
    const double usual = share_of_fish(rendered("usual", calm_));
    calm_.fish_density = 20.0;
    const double many = share_of_fish(rendered("many", calm_));
    EXPECT_GT(many, 0.02);
    EXPECT_GT(many, 4.0 * usual);
}

TEST_F(AlteredDivesTest, LessLightIsDarker) {
    const double usual = brightness(left_images(rendered("usual", calm_)).front());
    calm_.light = 0.1;
    const double dark = brightness(left_images(rendered("dark", calm_)).front());
    EXPECT_NEAR(dark / usual, std::pow(0.1, 1.0 / 2.2), 0.05);
}

TEST_F(AlteredDivesTest, ThickerWaterTakesContrast) {
    const double usual = spread(left_images(rendered("usual", calm_)).front());
    calm_.turbidity = 8.0;
    EXPECT_LT(spread(left_images(rendered("thick", calm_)).front()), 0.6 * usual);
}

TEST_F(AlteredDivesTest, SlowRateTakesAFrameEveryFourSeconds) {
    calm_.length_m = 3.0;
    calm_.rate_hz = 0.25;
    const auto dive = opened(rendered("dive", calm_));
    ASSERT_GE(dive->num_frames(), 3);
    const auto first = dive->next_frame();
    const auto second = dive->next_frame();
    EXPECT_EQ(second->timestamp_ns - first->timestamp_ns, 4'000'000'000);
}

TEST_F(AlteredDivesTest, PausesOnALapAndARateBelowTheSlowestAreRefused) {
    calm_.out = folder_ / "dive";
    calm_.laps = 2;
    calm_.pauses = {{0.5, 1.0}};
    EXPECT_THROW(simulate(calm_), Error);
    calm_.laps = 0;
    calm_.rate_hz = 0.2;
    EXPECT_THROW(simulate(calm_), Error);
}

TEST_F(AlteredDivesTest, APortIsDescribedUnlessItShouldNotBeAndBendsTheSameImages) {
    const fs::path without = rendered("without", calm_);
    calm_.ports = SimulatedPorts{.distance_m = 0.02};
    calm_.salinity_psu = 0.0;
    const fs::path described = rendered("described", calm_);
    calm_.ports->described = false;
    const fs::path undescribed = rendered("undescribed", calm_);

    const auto dive = opened(described);
    ASSERT_TRUE(dive->rig().cam0.port && dive->rig().cam1.port);
    EXPECT_EQ(dive->rig().cam0.port->distance_m, 0.02);
    EXPECT_NEAR(dive->rig().cam0.port->water_index, 1.3355, 5e-4);  // fresh, of 14 degrees
    EXPECT_LT(dive->rig().cam0.port->normal.x(), 0.0);
    EXPECT_GT(dive->rig().cam1.port->normal.x(), 0.0);
    EXPECT_FALSE(opened(undescribed)->rig().cam0.port);
    EXPECT_NE(content(undescribed / "truth/cam0/sensor.yaml").find("port:"), std::string::npos);
    for (const fs::path& image : left_images(described)) {
        EXPECT_EQ(content(image), content(undescribed / "mav0/cam0/data" / image.filename()));
        EXPECT_NE(content(image), content(without / "mav0/cam0/data" / image.filename()));
    }
}

TEST_F(AlteredDivesTest, APortInAirAndALensOutsideOfItsDomeAreRefused) {
    calm_.out = folder_ / "dive";
    calm_.ports = SimulatedPorts{.shape = types::Port::Shape::Dome, .offset_m = 0.04};
    EXPECT_THROW(simulate(calm_), Error);
    calm_.ports = SimulatedPorts{};
    calm_.water = WaterKind::None;
    EXPECT_THROW(simulate(calm_), Error);
    EXPECT_FALSE(fs::exists(calm_.out));
}

}  // namespace
}  // namespace divemesh::simulator
