#include "worker/dive/stereo_delay.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "worker/dive/stereo_rays.hpp"

namespace divemesh::dive {
namespace {

constexpr double kInterval_s = 0.1;

types::Rig stated_rig() {
    types::Rig rig;
    for (types::Camera* camera : {&rig.cam0, &rig.cam1}) {
        camera->width_px = 1200;
        camera->height_px = 400;
        camera->fx_px = camera->fy_px = 700.0;
        camera->cx_px = 600.0;
        camera->cy_px = 200.0;
        camera->distortion = types::Distortion::None;
    }
    rig.T_imu_cam1.translation() = Eigen::Vector3d(0.5, 0.0, 0.0);
    return rig;
}

// How the right camera really is: its rotation about its own axes, and how late it exposes.
struct Truth {
    double pitch_deg = 0.0;
    double roll_deg = 0.0;
    double delay_s = 0.0;
    std::array<double, 8> gaps_s = {};  // by which each moment's image is later still
    double knock_deg = 0.0;             // that pitch and roll grow by at a moment
    std::size_t knocked_at = 8;

    Eigen::Matrix3d R_stated_true(std::size_t moment) const {
        constexpr double kRadPerDeg = std::numbers::pi / 180.0;
        const double knock = moment < knocked_at ? 0.0 : knock_deg;
        return (Eigen::AngleAxisd(kRadPerDeg * (pitch_deg + knock), Eigen::Vector3d::UnitX()) *
                Eigen::AngleAxisd(kRadPerDeg * (roll_deg + knock), Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    }
};

cv::Point2f pixel(const types::Camera& camera, const Eigen::Vector3d& p) {
    return {static_cast<float>(camera.cx_px + camera.fx_px * p.x() / p.z()),
            static_cast<float>(camera.cy_px + camera.fy_px * p.y() / p.z())};
}

// Returns what the cameras see of a rig that drives ahead over even ground: near things move
// fastest, and lie in the right image where a roll moves them least.
std::vector<EpipolarMoment> driving(const Truth& truth) {
    const types::Rig rig = stated_rig();
    const StereoRays rays(rig);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::normal_distribution<double> noise_px(0.0, 0.15);
    std::vector<EpipolarMoment> moments(8);
    for (std::size_t k = 0; k < moments.size(); ++k) {
        const double speed_m_s = 8.0 + 0.5 * static_cast<double>(k);
        const double right_later_s = truth.delay_s + truth.gaps_s[k];
        moments[k].num_corners = 150;
        for (int i = 0; i < 150; ++i) {
            const double depth_m = 12.0 + 6.0 * uniform(random);
            const Eigen::Vector3d p(
                0.7 * depth_m * uniform(random), i % 3 == 0 ? 2.0 * uniform(random) : 1.6, depth_m);
            const auto ahead_by = [&](double time_s) {
                return Eigen::Vector3d(p - Eigen::Vector3d(0.0, 0.0, speed_m_s * time_s));
            };
            const Eigen::Vector3d p_right =
                truth.R_stated_true(k).transpose() *
                (ahead_by(right_later_s) - rig.T_imu_cam1.translation());
            cv::Point2f in_right = pixel(rig.cam1, p_right);
            in_right.y += static_cast<float>(noise_px(random));
            const Eigen::Vector3d left = rays.left(pixel(rig.cam0, p));
            const Eigen::Vector3d later = rays.left(pixel(rig.cam0, ahead_by(kInterval_s)));
            const Eigen::Vector3d right = rays.right(in_right);
            EpipolarSample sample;
            sample.ray = left.head<2>();
            sample.right_ray = right.head<2>() / right.z();
            sample.error_px = rays.epipolar_error_px(left, right);
            sample.rate_px_s =
                (sample.error_px - rays.epipolar_error_px(later, right)) / kInterval_s;
            moments[k].samples.push_back(sample);
        }
    }
    return moments;
}

TEST(StereoDelayTest, AMisalignedCameraIsNotLate) {
    for (const double pitch_deg : {-1.0, 0.0, 0.4})
        for (const double roll_deg : {-1.0, -0.4, 0.0, 1.0}) {
            const StereoDelay delay =
                estimate_delay(driving({.pitch_deg = pitch_deg, .roll_deg = roll_deg}));
            EXPECT_TRUE(delay.is_determined);
            EXPECT_FALSE(delay.is_significant());
            EXPECT_LT(std::abs(delay.delay_s), 1e-3)
                << "pitch " << pitch_deg << ", roll " << roll_deg;
        }
}

// The rates are means over the tenth of a second that follows, in which what is near gets faster by
// a quarter.
TEST(StereoDelayTest, FindsTheDelayOfAMisalignedCamera) {
    for (const double pitch_deg : {-1.0, 0.0, 1.0})
        for (const double roll_deg : {-1.0, 0.0, 1.0})
            for (const double delay_s : {-0.02, 0.008}) {
                const StereoDelay delay = estimate_delay(
                    driving({.pitch_deg = pitch_deg, .roll_deg = roll_deg, .delay_s = delay_s}));
                EXPECT_TRUE(delay.is_significant())
                    << "pitch " << pitch_deg << ", roll " << roll_deg << ", " << delay_s << " s";
                EXPECT_NEAR(delay.delay_s, delay_s, 0.25 * std::abs(delay_s) + 5e-4);
            }
}

TEST(StereoDelayTest, FindsTheDelayBeyondGapsThatVary) {
    const std::array<double, 8> gaps_s = {0.02, -0.015, 0.01, -0.005, 0.005, -0.01, 0.015, -0.02};
    for (const double delay_s : {0.0, 0.008}) {
        const auto moments = driving({.pitch_deg = 0.4, .delay_s = delay_s, .gaps_s = gaps_s});

        const StereoDelay beyond =
            estimate_delay(without_gaps(moments, {gaps_s.begin(), gaps_s.end()}));

        EXPECT_EQ(beyond.is_significant(), delay_s > 0.0);
        EXPECT_NEAR(beyond.delay_s, delay_s, 0.25 * delay_s + 1.5e-3);
        EXPECT_LT(beyond.loss_px2, 0.5 * estimate_delay(moments).loss_px2) << delay_s;
    }
}

TEST(StereoDelayTest, ACameraThatIsKnockedInMidDiveIsNotLate) {
    for (const double knock_deg : {-0.3, 0.1, 0.5})
        for (const std::size_t knocked_at : {2U, 3U, 6U})
            for (const double delay_s : {0.0, 0.015}) {
                const StereoDelay delay = estimate_delay(driving({.pitch_deg = 0.2,
                                                                  .delay_s = delay_s,
                                                                  .knock_deg = knock_deg,
                                                                  .knocked_at = knocked_at}));
                EXPECT_EQ(delay.is_significant(), delay_s > 0.0);
                EXPECT_NEAR(delay.delay_s, delay_s, 0.25 * delay_s + 1e-3)
                    << knock_deg << " degrees at moment " << knocked_at;
            }
}

// Returns what a camera sees that is too slow for features to be found in its next image.
std::vector<EpipolarMoment> without_later_images(std::vector<EpipolarMoment> moments) {
    for (EpipolarMoment& moment : moments) {
        for (EpipolarSample& sample : moment.samples) sample.rate_px_s = 0.0;
        moment.without_rate = std::move(moment.samples);
        moment.samples.clear();
    }
    return moments;
}

TEST(StereoDelayTest, PairsAreTestedWithoutMotion) {
    auto moments = without_later_images(driving({.pitch_deg = 0.4}));
    const StereoDelay matching = estimate_delay(moments);
    EXPECT_GT(matching.share_fitting.value_or(0.0), 0.9);
    EXPECT_FALSE(matching.is_determined);

    std::mt19937 random(5);
    std::uniform_real_distribution<double> anywhere_px(-30.0, 30.0);
    for (EpipolarMoment& moment : moments) {
        for (EpipolarSample& sample : moment.without_rate) sample.error_px = anywhere_px(random);
        moment.num_mismatches = 150;
        moment.num_corners = 300;
    }
    const StereoDelay other = estimate_delay(moments);
    ASSERT_TRUE(other.share_fitting.has_value());
    EXPECT_LT(*other.share_fitting, 0.05);
}

TEST(StereoDelayTest, AFewCornersTellNothing) {
    EpipolarMoment moment;
    moment.num_corners = 40;
    EXPECT_FALSE(estimate_delay({moment}).share_fitting.has_value());

    moment.num_corners = 60;
    EXPECT_EQ(estimate_delay({moment}).share_fitting, 0.0);
}

}  // namespace
}  // namespace divemesh::dive
