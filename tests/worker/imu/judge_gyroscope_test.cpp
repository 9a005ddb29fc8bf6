#include "worker/imu/judge_gyroscope.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::imu {
namespace {

constexpr double kStill_s = 1000.0;  // later the rig does not turn

// Returns a diver's orientation: swaying about all three axes at frequencies that do not repeat.
Eigen::Quaterniond q_world_body(double t_s) {
    const double t = std::min(t_s, kStill_s);
    return base::rotation_from_vector({0.15 * std::sin(1.1 * t) + 0.1 * std::sin(2.3 * t), 0, 0}) *
           base::rotation_from_vector({0, 0.2 * std::sin(0.8 * t + 0.5), 0}) *
           base::rotation_from_vector({0, 0, 0.2 * t + 0.25 * std::sin(0.63 * t + 1.0)});
}

// Returns 24 s of a gyroscope at 200 Hz with a bias, as `wrong` changes each reading.
template <typename Wrong>
std::vector<types::ImuSample> gyroscope(double start_s, const Wrong& wrong) {
    std::vector<types::ImuSample> samples;
    for (int i = -300; i <= 4800; ++i) {
        const double t_s = start_s + 0.005 * i;
        constexpr double kHalf_s = 1e-3;
        types::ImuSample sample;
        sample.timestamp_ns = std::llround(1e9 * t_s);
        sample.angular_velocity_imu =
            base::vector_from_rotation(q_world_body(t_s - kHalf_s).conjugate() *
                                       q_world_body(t_s + kHalf_s)) /
                (2.0 * kHalf_s) +
            Eigen::Vector3d(0.01, -0.02, 0.015);
        wrong(sample);
        samples.push_back(sample);
    }
    return samples;
}

// Returns the turns that cameras at 10 Hz see in 20 s, one rotation in twelve wrong by `times` the
// noise.
std::vector<RotationSpan> turns(double start_s, double times = 100.0) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0.0, 3e-4);
    RotationSpans spans;
    for (int i = 0; i < 200; ++i) {
        const auto time_ns = [&](int k) { return std::llround(1e9 * (start_s + 0.1 * k)); };
        const double wrong = i % 12 == 5 ? times : 1.0;
        const Eigen::Vector3d noise(normal(random), normal(random), normal(random));
        spans.add(
            {time_ns(i),
             time_ns(i + 1),
             q_world_body(start_s + 0.1 * i).conjugate() * q_world_body(start_s + 0.1 * (i + 1)) *
                 base::rotation_from_vector(wrong * noise)});
    }
    return spans.spans();
}

template <typename Wrong>
GyroscopeJudgement judged(const Wrong& wrong) {
    return judge_gyroscope(gyroscope(0.0, wrong), turns(0.0));
}

void as_measured(types::ImuSample&) {}

TEST(JudgeGyroscopeTest, AGoodGyroscopeFits) {
    EXPECT_EQ(judged(as_measured).fit, GyroscopeFit::Fits);
}

TEST(JudgeGyroscopeTest, SmallErrorsThatTheAlignmentMendsFit) {
    const auto judgement = judged([](types::ImuSample& sample) {
        sample.timestamp_ns += 30'000'000;
        sample.angular_velocity_imu =
            base::rotation_from_vector({0.1, -0.1, 0.1}) * sample.angular_velocity_imu;
    });
    EXPECT_EQ(judgement.fit, GyroscopeFit::Fits);
}

TEST(JudgeGyroscopeTest, ScalesThatNoGyroscopeHasContradict) {
    for (const double scale : {0.6, 0.8, 1.2, 1.3, 1.6}) {
        const auto scaled = [&](types::ImuSample& sample) { sample.angular_velocity_imu *= scale; };
        const auto judgement = judge_gyroscope(gyroscope(0.0, scaled), turns(0.0, 10.0));
        EXPECT_EQ(judgement.fit, GyroscopeFit::Contradicts) << scale;
        EXPECT_EQ(judgement.fault, GyroscopeFault::Scaled) << scale;
        EXPECT_NEAR(judgement.scale, scale, 0.03 * scale);
    }
    for (const double scale : {0.95, 1.05})
        EXPECT_EQ(
            judged([&](types::ImuSample& sample) { sample.angular_velocity_imu *= scale; }).fit,
            GyroscopeFit::Fits)
            << scale;
}

TEST(JudgeGyroscopeTest, FindsAClockThatIsOffByUpToASecond) {
    for (const double offset_s : {-0.9, -0.25, 0.25, 0.8}) {
        const auto judgement = judged(
            [&](types::ImuSample& sample) { sample.timestamp_ns += std::llround(1e9 * offset_s); });
        EXPECT_EQ(judgement.fit, GyroscopeFit::FitsShifted) << offset_s;
        EXPECT_NEAR(judgement.time_offset_s, offset_s, 0.02);
    }
}

// Between what the alignment finds while a dive is tracked (60 ms) and what no longer fits at all.
TEST(JudgeGyroscopeTest, FindsAClockThatIsOffByLittleMoreThanTheAlignmentFinds) {
    for (const double offset_s : {-0.1, -0.07, 0.066, 0.07, 0.08, 0.1}) {
        const auto judgement = judged(
            [&](types::ImuSample& sample) { sample.timestamp_ns += std::llround(1e9 * offset_s); });
        EXPECT_EQ(judgement.fit, GyroscopeFit::FitsShifted) << offset_s;
        EXPECT_NEAR(judgement.time_offset_s, offset_s, 0.005) << offset_s;
    }
}

// Every offset fits a rig that turns slowly and evenly.
TEST(JudgeGyroscopeTest, ARigThatSwaysSlowlyShowsNoOffset) {
    for (std::uint32_t seed = 1; seed <= 60; ++seed) {
        std::mt19937 random(seed);
        std::normal_distribution<double> noise_rad_s(0.0, 0.006);
        std::uniform_real_distribution<double> uniform(0.0, 6.0);
        const Eigen::Vector3d phase(uniform(random), uniform(random), uniform(random));
        const auto rate_at = [&](double t_s) {
            return Eigen::Vector3d(0.03 * (0.9 * t_s + phase.array()).sin());
        };
        std::vector<types::ImuSample> samples;
        for (int i = -300; i <= 3000; ++i) {
            types::ImuSample sample;
            sample.timestamp_ns = std::int64_t{5'000'000} * i;
            sample.angular_velocity_imu = rate_at(0.005 * i);
            samples.push_back(sample);
        }
        std::vector<RotationSpan> spans;
        for (int i = 0; i < 20; ++i) {
            const double from_s = 0.3 * i;
            const Eigen::Vector3d noise(
                noise_rad_s(random), noise_rad_s(random), noise_rad_s(random));
            spans.push_back({std::llround(1e9 * from_s),
                             std::llround(1e9 * (from_s + 0.3)),
                             rate_at(from_s + 0.15) + noise});
        }
        EXPECT_NE(judge_gyroscope(samples, spans).fit, GyroscopeFit::FitsShifted) << seed;
    }
}

TEST(JudgeGyroscopeTest, AnOffsetThatTheAlignmentFindsIsNear) {
    for (const double offset_s : {-0.058, 0.045, 0.052, 0.058}) {
        const auto judgement = judged(
            [&](types::ImuSample& sample) { sample.timestamp_ns += std::llround(1e9 * offset_s); });
        EXPECT_EQ(judgement.fit, GyroscopeFit::Fits) << offset_s;
    }
}

TEST(JudgeGyroscopeTest, ABiasThatNoGyroscopeHasContradictsAfterThreeSeconds) {
    const auto off_by = [](double bias_rad_s) {
        const auto samples = gyroscope(kStill_s + 10.0, [&](types::ImuSample& sample) {
            sample.angular_velocity_imu.y() += bias_rad_s;
        });
        const auto seen = turns(kStill_s + 10.0);
        return judge_gyroscope(samples, {seen.begin(), seen.begin() + 9});
    };
    const auto judgement = off_by(4.5);  // a bias of 0.08 rad/s in degrees
    EXPECT_EQ(judgement.fit, GyroscopeFit::Contradicts);
    EXPECT_EQ(judgement.fault, GyroscopeFault::Biased);
    EXPECT_NEAR(judgement.bias_rad_s, 4.5, 0.3);  // the smallest difference
    EXPECT_EQ(off_by(0.3).fit, GyroscopeFit::Unknown);
    // A gyroscope with mirrored axes differs by more from a rig that turns, but turns as fast.
    const auto mirrored = gyroscope(0.0, [](types::ImuSample& sample) {
        sample.angular_velocity_imu = -3.0 * sample.angular_velocity_imu;
    });
    auto seen = turns(0.0);
    for (RotationSpan& span : seen) span.rate_body *= 3.0;
    EXPECT_NE(judge_gyroscope(mirrored, seen).fault, GyroscopeFault::Biased);
}

TEST(JudgeGyroscopeTest, AClockThatIsOffByMoreIsNotTakenForOneThatIsOffByASecond) {
    for (const double offset_s : {-1.2, -1.05, 1.05, 1.2}) {
        const auto judgement = judged(
            [&](types::ImuSample& sample) { sample.timestamp_ns += std::llround(1e9 * offset_s); });
        EXPECT_EQ(judgement.fit, GyroscopeFit::Contradicts) << offset_s;
        EXPECT_EQ(judgement.fault, GyroscopeFault::Unexplained) << offset_s;
    }
}

TEST(JudgeGyroscopeTest, NamesTheMirroredAxis) {
    for (int axis = 0; axis < 3; ++axis) {
        const auto judgement =
            judged([&](types::ImuSample& sample) { sample.angular_velocity_imu[axis] *= -1.0; });
        EXPECT_EQ(judgement.fit, GyroscopeFit::Contradicts);
        EXPECT_EQ(judgement.fault, GyroscopeFault::Mirrored);
        EXPECT_EQ(judgement.axes, std::string(1, "xyz"[axis]));
    }
}

TEST(JudgeGyroscopeTest, NamesExchangedAxes) {
    const auto judgement = judged([](types::ImuSample& sample) {
        std::swap(sample.angular_velocity_imu.x(), sample.angular_velocity_imu.y());
    });
    EXPECT_EQ(judgement.fit, GyroscopeFit::Contradicts);
    EXPECT_EQ(judgement.fault, GyroscopeFault::Mirrored);
    EXPECT_EQ(judgement.axes, "x and y");
}

TEST(JudgeGyroscopeTest, NamesWrongUnits) {
    const auto judgement =
        judged([](types::ImuSample& sample) { sample.angular_velocity_imu *= 0.4; });
    EXPECT_EQ(judgement.fit, GyroscopeFit::Contradicts);
    EXPECT_EQ(judgement.fault, GyroscopeFault::Scaled);
    EXPECT_NEAR(judgement.scale, 0.4, 0.05);
}

TEST(JudgeGyroscopeTest, AnotherDivesGyroscopeContradicts) {
    std::vector<types::ImuSample> other = gyroscope(300.0, as_measured);
    for (types::ImuSample& sample : other) sample.timestamp_ns -= 300'000'000'000;
    const auto judgement = judge_gyroscope(other, turns(0.0));
    EXPECT_EQ(judgement.fit, GyroscopeFit::Contradicts);
    EXPECT_EQ(judgement.fault, GyroscopeFault::Unexplained);
}

TEST(JudgeGyroscopeTest, ARigThatDoesNotTurnTellsNothing) {
    const auto judgement =
        judge_gyroscope(gyroscope(kStill_s + 10.0, as_measured), turns(kStill_s + 10.0));
    EXPECT_EQ(judgement.fit, GyroscopeFit::Unknown);
}

TEST(JudgeGyroscopeTest, AGyroscopeThatTurnsWhileTheImagesRestContradicts) {
    std::vector<types::ImuSample> other = gyroscope(0.0, as_measured);
    for (types::ImuSample& sample : other)
        sample.timestamp_ns += std::llround(1e9 * (kStill_s + 10.0));
    EXPECT_EQ(judge_gyroscope(other, turns(kStill_s + 10.0)).fit, GyroscopeFit::Contradicts);
}

}  // namespace
}  // namespace divemesh::imu
