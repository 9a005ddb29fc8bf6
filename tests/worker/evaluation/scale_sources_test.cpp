#include "worker/evaluation/scale_sources.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "worker/evaluation/combined_scale.hpp"

namespace divemesh::evaluation {
namespace {

constexpr double kCamerasSigma = 0.003;

// A path of a minute up and down, and the depth that a recorder states whose density is `density`
// times the water's.
struct UpAndDown {
    explicit UpAndDown(double density) {
        for (int i = 0; i <= 600; ++i) {
            const std::int64_t time_ns = i * std::int64_t{100'000'000};
            types::StampedPose pose{time_ns, Eigen::Isometry3d::Identity()};
            pose.T_world_imu.translation() =
                Eigen::Vector3d(0.03 * i, std::sin(0.13 * i), 0.8 * std::sin(0.04 * i));
            trajectory.push_back(pose);
            data.pressure.push_back(
                {time_ns,
                 (7.0 - pose.T_world_imu.translation().z() + 1e-3 * std::sin(37.0 * i)) / density});
        }
        path.scale_sigma = kCamerasSigma;
    }
    ScaleSources sources() const { return scale_sources(data, trajectory, path, {}); }

    LengthData data;
    types::Trajectory trajectory;
    types::PathUncertainty path;
};

bool left_out(const ScaleSources& sources, const std::string& metric, const std::string& reason) {
    return std::any_of(sources.left_out.begin(), sources.left_out.end(), [&](const LeftOut& left) {
        return left.metric == metric && left.reason.find(reason) != std::string::npos;
    });
}

TEST(ScaleSourcesTest, ARecorderSetToTheWrongWaterCorrectsNothing) {
    for (const double density : {0.97, 1.0, 1.025, 1.03}) {
        const ScaleSources sources = UpAndDown(density).sources();
        ASSERT_EQ(sources.usable.size(), 1U);
        EXPECT_EQ(sources.usable[0].name, "pressure");
        EXPECT_NEAR(sources.usable[0].check.scale, 1.0 / density, 2e-3);
        EXPECT_FALSE(scale_correction(sources.usable, kCamerasSigma)) << density;
    }
    // No water is as heavy as that.
    EXPECT_TRUE(scale_correction(UpAndDown(1.09).sources().usable, kCamerasSigma));
}

TEST(ScaleSourcesTest, ACheckIsJudgedByItsOwnSigma) {
    UpAndDown dive(1.0);
    dive.path.scale_sigma = 0.5;
    EXPECT_EQ(dive.sources().usable.size(), 1U);
    dive.path.vertical_scale_sigma = 0.2;
    EXPECT_TRUE(dive.sources().usable.empty());
    EXPECT_TRUE(left_out(dive.sources(), "scale.pressure", "20.2 %"));
    dive.path.vertical_scale_sigma = 0.04;
    EXPECT_EQ(dive.sources().usable.size(), 1U);
    types::LoopStatistics loops;
    loops.num_accepted = 1;
    loops.residual_sigmas = 3.0;
    EXPECT_TRUE(scale_sources(dive.data, dive.trajectory, dive.path, loops).usable.empty());
}

// No water is 9 % heavier than fresh water; 3 % is what recorders err by.
TEST(ScaleSourcesTest, AScaleBeyondThreeOfItsSigmasContradictsThePath) {
    const auto contradiction = [](double density) {
        const UpAndDown dive(density);
        return scale_contradiction(dive.sources().usable, dive.path);
    };
    EXPECT_EQ(contradiction(1.03), 0.0);
    EXPECT_NEAR(contradiction(1.09), 1.0 - 1.0 / 1.09, 2e-3);
    // A path that is known to no better than that contradicts nothing.
    UpAndDown vague(1.09);
    vague.path.scale_sigma = 0.05;
    EXPECT_EQ(scale_contradiction(vague.sources().usable, vague.path), 0.0);
}

// An accelerometer whose unit is off by `factor`, on the same dive.
std::vector<types::ImuSample> forces(double factor) {
    std::vector<types::ImuSample> imu;
    for (int i = 0; i <= 12'000; ++i) {
        const double t = 0.05 * i;  // in steps of the path
        types::ImuSample sample;
        sample.timestamp_ns = i * std::int64_t{5'000'000};
        // The second derivative of the path, whose steps take 0.1 s.
        const Eigen::Vector3d acceleration(
            0.0, -0.13 * 0.13 * std::sin(0.13 * t), -0.8 * 0.04 * 0.04 * std::sin(0.04 * t));
        sample.acceleration_imu =
            factor *
            (100.0 * acceleration + Eigen::Vector3d(0.0, 0.0, 9.81) +
             0.02 * Eigen::Vector3d(std::sin(71.0 * i), std::sin(83.0 * i), std::sin(97.0 * i)));
        imu.push_back(sample);
    }
    return imu;
}

TEST(ScaleSourcesTest, AnAccelerometerWhoseGravityIsWrongCorrectsNothing) {
    UpAndDown dive(1.0);
    dive.data.pressure.clear();
    for (const double factor : {0.95, 1.0, 1.05}) {
        dive.data.imu = forces(factor);
        const ScaleSources sources = dive.sources();
        ASSERT_EQ(sources.usable.size(), 1U) << factor;
        EXPECT_EQ(sources.usable[0].name, "accelerometer");
        EXPECT_NEAR(sources.usable[0].check.scale, factor, 0.01);
        EXPECT_FALSE(scale_correction(sources.usable, kCamerasSigma)) << factor;
    }
    EXPECT_GT(dive.sources().usable[0].check.sigma, 0.035);
    // One with the right gravity does.
    dive.data.imu = forces(1.0);
    for (types::StampedPose& pose : dive.trajectory) pose.T_world_imu.translation() *= 0.95;
    EXPECT_TRUE(scale_correction(dive.sources().usable, kCamerasSigma));
}

TEST(ScaleSourcesTest, AnAccelerometerThatSaysNoScaleSaysWhy) {
    const auto says = [](const std::string& reason, const auto& change) {
        UpAndDown dive(1.0);
        dive.data.imu = forces(1.0);
        change(dive);
        return left_out(dive.sources(), "scale.accelerometer", reason);
    };
    const auto keep_frames = [](UpAndDown& dive, const auto& is_kept) {
        types::Trajectory kept;
        for (std::size_t i = 0; i < dive.trajectory.size(); ++i)
            if (is_kept(i)) kept.push_back(dive.trajectory[i]);
        dive.trajectory = kept;
    };
    EXPECT_TRUE(says("no IMU", [](UpAndDown& dive) { dive.data.imu.clear(); }));
    EXPECT_TRUE(says("frames are further apart than 0.6 s", [&](UpAndDown& dive) {
        keep_frames(dive, [](std::size_t i) { return i % 10 == 0; });
    }));
    EXPECT_TRUE(says("shorter than the 6.0 s", [&](UpAndDown& dive) {
        keep_frames(dive, [](std::size_t i) { return i < 50; });
    }));
    EXPECT_TRUE(says("frames of the path are missing", [&](UpAndDown& dive) {
        keep_frames(dive, [](std::size_t i) { return i % 10 != 1 && i % 10 != 2; });
    }));
    EXPECT_TRUE(says("the IMU covers too little", [](UpAndDown& dive) {
        dive.data.imu.resize(600);  // three seconds
    }));
}

TEST(ScaleSourcesTest, SegmentsHaveNoMotionInCommon) {
    UpAndDown dive(1.0);
    dive.data.markers = ScaleCheck{0.99, 0.002};
    dive.data.num_segments = 2;
    const ScaleSources sources = dive.sources();
    ASSERT_EQ(sources.usable.size(), 1U);
    EXPECT_EQ(sources.usable[0].name, "markers");
    EXPECT_TRUE(left_out(sources, "scale.pressure", "several segments"));
    EXPECT_TRUE(left_out(sources, "scale.accelerometer", "several segments"));
    EXPECT_TRUE(left_out(sources, "scale.known_distances", "three"));
}

}  // namespace
}  // namespace divemesh::evaluation
