#include "worker/imu/estimate_alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::imu {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;

// Returns a diver's swaying orientation: rotations about all three axes, a few degrees per second.
Eigen::Quaterniond q_world_body(double t) {
    return base::rotation_from_vector({0.1 * std::sin(1.1 * t), 0.0, 0.0}) *
           base::rotation_from_vector({0.0, 0.12 * std::sin(0.8 * t + 0.5), 0.0}) *
           base::rotation_from_vector({0.0, 0.0, 0.3 * t + 0.15 * std::sin(0.6 * t + 1.0)});
}

// Returns 30 s of a gyroscope at 200 Hz whose rotation and time stamps have the given `error`.
std::vector<types::ImuSample> gyroscope(const types::ImuAlignment& error) {
    std::vector<types::ImuSample> samples;
    for (int i = -100; i <= 6100; ++i) {
        const double t = 0.005 * i;
        constexpr double kStep = 1e-4;
        const Eigen::Vector3d rate_body =
            base::vector_from_rotation(q_world_body(t - kStep).conjugate() *
                                       q_world_body(t + kStep)) /
            (2.0 * kStep);
        types::ImuSample sample;
        sample.timestamp_ns = std::int64_t{5'000'000} * i + std::llround(1e9 * error.time_offset_s);
        sample.angular_velocity_imu =
            error.q_body_imu.conjugate() * rate_body + Eigen::Vector3d(0.01, -0.02, 0.015);
        samples.push_back(sample);
    }
    return samples;
}

// Returns the rotations by vision at 10 Hz, one in twelve of them wrong.
std::vector<VisionRotation> vision_rotations(double noise_rad, double wrong_rad) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    const auto noise = [&](double sigma) {
        return base::rotation_from_vector(
            sigma * Eigen::Vector3d(normal(random), normal(random), normal(random)));
    };
    std::vector<VisionRotation> rotations;
    for (int i = 0; i < 300; ++i) {
        VisionRotation rotation;
        rotation.from_ns = std::int64_t{100'000'000} * i;
        rotation.to_ns = rotation.from_ns + 100'000'000;
        rotation.q_from_to = q_world_body(0.1 * i).conjugate() * q_world_body(0.1 * (i + 1)) *
                             noise(noise_rad) * noise(i % 12 == 5 ? wrong_rad : 0.0);
        rotations.push_back(rotation);
    }
    return rotations;
}

types::ImuAlignment injected(double offset_s, const Eigen::Vector3d& rotation_deg) {
    return {offset_s, base::rotation_from_vector(kDeg * rotation_deg)};
}

TEST(ImuAlignmentTest, FindsOffsetAndRotationExactlyWithoutNoise) {
    for (const double offset_s : {-0.066, -0.045, -0.008, 0.0, 0.008, 0.03, 0.066}) {
        const types::ImuAlignment error = injected(offset_s, {0.7, -0.5, 0.5});
        const auto estimate = estimate_alignment(gyroscope(error), vision_rotations(0.0, 0.0));

        ASSERT_TRUE(estimate);
        EXPECT_NEAR(estimate->alignment.time_offset_s, offset_s, 1e-4);
        EXPECT_LT(estimate->alignment.q_body_imu.angularDistance(error.q_body_imu), 0.02 * kDeg);
    }
}

TEST(ImuAlignmentTest, FindsEightMillisecondsAndOneDegreeInNoiseWithWrongTurns) {
    const types::ImuAlignment error = injected(0.008, {0.6, -0.5, 0.62});
    const auto estimate = estimate_alignment(gyroscope(error), vision_rotations(2e-4, 0.05));

    ASSERT_TRUE(estimate);
    EXPECT_NEAR(estimate->alignment.time_offset_s, 0.008, 4.0 * estimate->time_offset_sigma_s);
    EXPECT_LT(estimate->time_offset_sigma_s, 2e-3);
    EXPECT_LT(estimate->alignment.q_body_imu.angularDistance(error.q_body_imu), 0.3 * kDeg);
    EXPECT_TRUE(estimate->time_offset_is_significant());
    EXPECT_TRUE(estimate->rotation_is_significant());
}

TEST(ImuAlignmentTest, LeavesAGoodCalibrationAlone) {
    const auto estimate = estimate_alignment(gyroscope({}), vision_rotations(2e-4, 0.05));

    ASSERT_TRUE(estimate);
    EXPECT_FALSE(estimate->time_offset_is_significant());
    EXPECT_FALSE(estimate->rotation_is_significant());
}

// Errors of consecutive rotations share landmarks: here each is the mean of eight independent ones.
TEST(ImuAlignmentTest, ErrorsThatLastForSomeRotationsAreNotTakenForAnOffset) {
    constexpr int kShared = 8, kNumDives = 100;
    constexpr double kSigma_rad = 7e-4;
    const std::vector<types::ImuSample> samples = gyroscope({});
    int num_significant = 0;
    double sum_squares = 0.0;
    for (std::uint32_t seed = 1; seed <= kNumDives; ++seed) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        std::vector<VisionRotation> rotations = vision_rotations(0.0, 0.0);
        rotations.resize(100);
        std::vector<Eigen::Vector3d> errors(rotations.size() + kShared);
        for (Eigen::Vector3d& error : errors)
            error << normal(random), normal(random), normal(random);
        for (std::size_t i = 0; i < rotations.size(); ++i) {
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            for (int k = 0; k < kShared; ++k) sum += errors[i + k];
            rotations[i].q_from_to =
                rotations[i].q_from_to *
                base::rotation_from_vector(kSigma_rad / std::sqrt(double{kShared}) * sum);
        }
        const auto estimate = estimate_alignment(samples, rotations);
        ASSERT_TRUE(estimate);
        num_significant +=
            estimate->time_offset_is_significant() || estimate->rotation_is_significant();
        sum_squares +=
            std::pow(estimate->alignment.time_offset_s / estimate->time_offset_sigma_s, 2);
    }
    EXPECT_LE(num_significant, kNumDives / 20);
    EXPECT_LT(std::sqrt(sum_squares / kNumDives), 1.3);
    EXPECT_GT(std::sqrt(sum_squares / kNumDives), 0.5);
}

TEST(ImuAlignmentTest, SaysNothingOfAnOffsetBeyondItsReach) {
    for (const double offset_s : {-0.09, 0.08, 0.09})
        EXPECT_FALSE(estimate_alignment(gyroscope(injected(offset_s, Eigen::Vector3d::Zero())),
                                        vision_rotations(0.0, 0.0)))
            << offset_s;
}

TEST(ImuAlignmentTest, SaysNothingWithoutSamplesOrTurns) {
    EXPECT_FALSE(estimate_alignment({}, vision_rotations(0.0, 0.0)));
    EXPECT_FALSE(estimate_alignment(gyroscope({}), {}));
}

TEST(ImuAlignmentTest, SaysNothingOfARigAtRestWhateverANoisyGyroscopeMeasures) {
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        std::vector<types::ImuSample> samples;
        for (int i = -2; i <= 60; ++i) {  // at 10 Hz, of which now and then one is far off
            types::ImuSample sample;
            sample.timestamp_ns = std::int64_t{100'000'000} * i;
            const double sigma = i % 9 == 3 ? 0.2 : 0.01;
            sample.angular_velocity_imu =
                sigma * Eigen::Vector3d(normal(random), normal(random), normal(random));
            samples.push_back(sample);
        }
        std::vector<VisionRotation> rotations;
        for (int i = 0; i < 100; ++i) {
            const std::int64_t from_ns = std::int64_t{50'000'000} * i;
            rotations.push_back(
                {from_ns,
                 from_ns + 50'000'000,
                 base::rotation_from_vector(
                     2e-4 * Eigen::Vector3d(normal(random), normal(random), normal(random)))});
        }
        EXPECT_FALSE(estimate_alignment(samples, rotations)) << seed;
    }
}

TEST(ImuAlignmentTest, AlignedSamplesAreThoseOfAUnitThatSitsAsCalibrated) {
    const types::ImuAlignment error = injected(0.008, {0.6, -0.5, 0.62});
    const auto straight = gyroscope({});
    const auto undone = aligned(gyroscope(error), error);

    ASSERT_EQ(undone.size(), straight.size());
    EXPECT_EQ(undone[50].timestamp_ns, straight[50].timestamp_ns);
    const Eigen::Vector3d bias(0.01, -0.02, 0.015);
    EXPECT_LT((undone[50].angular_velocity_imu - straight[50].angular_velocity_imu -
               (error.q_body_imu * bias - bias))
                  .norm(),
              1e-12);
}

}  // namespace
}  // namespace divemesh::imu
