#include "worker/optimisation/frame_covariances.hpp"

#include <gtest/gtest.h>

namespace divemesh::optimisation {
namespace {

// Eleven frames with keyframes at the first, the sixth and the eleventh. The odometry is off by
// `miss_m` to the side from the second keyframe on, and by twice that from the third.
struct Followed {
    explicit Followed(double miss_m) : odometry(11), sigmas(11, {0.01, 0.001}) {
        for (std::size_t i = 0; i < odometry.size(); ++i) {
            odometry[i].timestamp_ns = 100 * static_cast<std::int64_t>(i);
            odometry[i].T_world_imu.translation().x() = static_cast<double>(i);
            odometry[i].T_world_imu.translation().y() = i < 5 ? 0.0 : i < 10 ? miss_m : 2 * miss_m;
        }
        for (const std::int64_t i : {0, 5, 10}) {
            types::Keyframe keyframe;
            keyframe.timestamp_ns = 100 * i;
            keyframe.T_world_cam.translation().x() = static_cast<double>(i);
            keyframes.push_back(keyframe);
            covariances.push_back({100 * i,
                                   0.4 * static_cast<double>(i) * Eigen::Matrix3d::Identity(),
                                   Eigen::Matrix3d::Identity()});
        }
    }
    types::CovarianceTrack at_frames() const {
        return covariances_at(
            covariances, odometry, sigmas, keyframes, Eigen::Isometry3d::Identity());
    }

    types::Trajectory odometry;
    std::vector<types::MotionSigma> sigmas;
    std::vector<types::Keyframe> keyframes;
    types::CovarianceTrack covariances;
};

TEST(FrameCovarianceTest, OfFramesLiesBetweenThoseOfTheKeyframes) {
    const types::CovarianceTrack at = Followed(0.0).at_frames();
    ASSERT_EQ(at.size(), 11U);
    EXPECT_EQ(at[0].position_m2(0, 0), 0.0);
    EXPECT_NEAR(at[2].position_m2(0, 0), 0.8, 1e-12);
    EXPECT_NEAR(at[2].rotation_rad2(1, 1), 1.0, 1e-12);
    EXPECT_NEAR(at[10].position_m2(2, 2), 4.0, 1e-12);
}

TEST(FrameCovarianceTest, FramesBetweenKeyframesHaveTheErrorOfTheirOdometry) {
    const types::CovarianceTrack at = Followed(0.3).at_frames();
    // Per axis 0.3^2 / 3 over five steps; the median of three values is below their mean.
    const double whole = 0.03 * 3.0 / 2.365973884375;
    EXPECT_NEAR(at[2].position_m2(0, 0) - 0.8, 0.4 * 0.6 * whole, 1e-9);
    EXPECT_NEAR(at[5].position_m2(0, 0), 2.0, 1e-12);
}

TEST(FrameCovarianceTest, BesideAnUncertainStepFramesAreKnownAsWellAsTheNearerKeyframe) {
    Followed followed(0.3);
    followed.sigmas[4] = {0.07, 0.001};  // a variance of 49 others, of 53 in the interval
    const types::CovarianceTrack at = followed.at_frames();
    // The other interval sets by how much errors exceed what is stated; the median of three values
    // is below their mean.
    const double whole_m2 = 53.0 / 5.0 * 0.03 * 3.0 / 2.365973884375;
    const auto between = [&](std::size_t i) {
        return at[i].position_m2(0, 0) - 0.4 * static_cast<double>(i);
    };
    EXPECT_NEAR(between(3), whole_m2 * 3.0 / 53.0 * 50.0 / 53.0, 1e-9);
    EXPECT_NEAR(between(4), whole_m2 * 52.0 / 53.0 * 1.0 / 53.0, 1e-9);
    // In the other interval the steps are equal.
    EXPECT_NEAR(between(7), 0.24 / 0.16 * between(6), 1e-9);
}

}  // namespace
}  // namespace divemesh::optimisation
