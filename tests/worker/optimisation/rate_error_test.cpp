#include <gtest/gtest.h>

#include <variant>

#include "tests/synthetic/stereo_world.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/bundle_adjustment.hpp"

namespace divemesh::optimisation {
namespace {

constexpr std::int64_t kDuration_ns = 2'000'000'000;
constexpr double kDuration_s = 2.0;
constexpr double kSigma = 0.01;  // of the shares by which the rates are too large

Eigen::Vector3d rate() { return {0.15, -0.2, 0.3}; }

// Returns the true rotation in two seconds where the measured rates are too large by the shares.
Eigen::Quaterniond rotation(const Eigen::Vector3d& too_large) {
    return base::rotation_from_vector(kDuration_s * (rate() - too_large.cwiseProduct(rate())));
}

// A body that rotates at one rate and stays where it is. Only the gyroscope measures its rotation.
class RateErrorTest : public testing::Test {
protected:
    RateErrorTest() : bundle_adjustment_(synthetic::rig()) {
        for (int i = -2; i <= 402; ++i) {
            const double t_s = 0.005 * i;
            types::ImuSample sample{std::int64_t{5'000'000} * i};
            sample.angular_velocity_imu = rate();
            sample.acceleration_imu = base::rotation_from_vector(t_s * rate()).conjugate() *
                                      (imu::kGravity_m_s2 * Eigen::Vector3d::UnitZ());
            samples_.push_back(sample);
        }
        T_first_second_.linear() = rotation(Eigen::Vector3d::Zero()).toRotationMatrix();
        first_ = BodyState::at(Eigen::Isometry3d::Identity(), {});
        second_ = BodyState::at(T_first_second_, {});
        bundle_adjustment_.add_state(first_, true);
        bundle_adjustment_.add_state(second_, false);
        bundle_adjustment_.add_motion(first_, second_, T_first_second_, 0.01, 1e3);
        bundle_adjustment_.add_gyroscope_bias(first_, Eigen::Vector3d::Zero(), 1e-6);
    }
    // Returns what the error of the rates adds to the covariance of the second rotation.
    Eigen::Matrix3d added_rad2() {
        bundle_adjustment_.solve_sparse(10, base::ignore_progress, {});
        CalibrationUncertainty calibration;
        const auto rad2 = [&] {
            return bundle_adjustment_.covariances({&second_}, calibration)
                .states.at(0)
                .rotation_rad2;
        };
        const Eigen::Matrix3d exact_rad2 = rad2();
        calibration.rate_error_covariance = kSigma * kSigma * Eigen::Matrix3d::Identity();
        return rad2() - exact_rad2;
    }
    // Returns the same by differences of the true rotation, in the axes of the world.
    static Eigen::Matrix3d true_rad2() {
        constexpr double kStep = 1e-5;
        Eigen::Matrix3d G;
        for (int axis = 0; axis < 3; ++axis)
            G.col(axis) =
                base::vector_from_rotation(rotation(kStep * Eigen::Vector3d::Unit(axis)) *
                                           rotation(Eigen::Vector3d::Zero()).conjugate()) /
                kStep;
        return kSigma * kSigma * G * G.transpose();
    }

    std::vector<types::ImuSample> samples_;
    types::ImuNoise noise_{2e-4, 2e-5, 2e-3, 2e-4};
    Eigen::Isometry3d T_first_second_ = Eigen::Isometry3d::Identity();
    Eigen::Vector3d gravity_direction_world_ = -Eigen::Vector3d::UnitZ();
    BodyState first_;
    BodyState second_;
    BundleAdjustment bundle_adjustment_;
};

TEST_F(RateErrorTest, ARotationErrsByTheShareOfTheGyroscopesRates) {
    const auto integral =
        imu::integrate_gyroscope(samples_, 0, kDuration_ns, Eigen::Vector3d::Zero(), noise_);
    ASSERT_TRUE(integral);
    bundle_adjustment_.add_gyro_rotation(first_, second_, *integral, noise_.gyroscope_random_walk);
    const Eigen::Matrix3d difference = added_rad2() - true_rad2();
    EXPECT_LT(difference.norm(), 0.02 * true_rad2().norm());
}

TEST_F(RateErrorTest, AMotionByTheWholeImuErrsByTheShareOfItsRates) {
    const auto motion = imu::preintegrate(samples_, 0, kDuration_ns, {}, noise_);
    ASSERT_TRUE(std::holds_alternative<imu::PreintegratedImu>(motion));
    bundle_adjustment_.add_imu_preintegration(
        first_, second_, std::get<imu::PreintegratedImu>(motion), noise_, gravity_direction_world_);
    bundle_adjustment_.add_accelerometer_bias(first_, Eigen::Vector3d::Zero(), 1e-4);
    bundle_adjustment_.add_gravity_direction(
        gravity_direction_world_, -Eigen::Vector3d::UnitZ(), 1e-3);
    const Eigen::Matrix3d difference = added_rad2() - true_rad2();
    EXPECT_LT(difference.norm(), 0.02 * true_rad2().norm());
}

}  // namespace
}  // namespace divemesh::optimisation
