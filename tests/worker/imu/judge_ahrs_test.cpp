#include "worker/imu/judge_ahrs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::imu {
namespace {

constexpr double kDuration_s = 60.0;

// Returns the orientation of a rig that sways about all axes. Another `phase` is another dive.
Eigen::Quaterniond q_world_body(double t_s, double phase = 0.0) {
    const double t = t_s + phase;
    return base::rotation_from_vector({0.2 * std::sin(0.9 * t) + 0.1 * std::sin(2.1 * t), 0, 0}) *
           base::rotation_from_vector({0, 0.2 * std::sin(0.7 * t), 0}) *
           base::rotation_from_vector({0, 0, 0.1 * t + 0.2 * std::sin(1.3 * t)});
}

// Judges an AHRS that reads `reading(t_s)`, every `step_s`.
template <typename Reading>
AhrsJudgement judged(const Reading& reading, double step_s = 0.02) {
    std::vector<types::OrientationSample> orientations;
    for (double t_s = -2.0; t_s < kDuration_s + 2.0; t_s += step_s)
        orientations.push_back({std::llround(1e9 * t_s), reading(t_s)});
    RotationSpans turns;
    for (int k = 0; k < std::lround(10.0 * kDuration_s); ++k) {
        const double from_s = 0.1 * k;
        const double to_s = 0.1 * (k + 1);
        turns.add({std::llround(1e9 * from_s),
                   std::llround(1e9 * to_s),
                   q_world_body(from_s).conjugate() * q_world_body(to_s)});
    }
    return judge_ahrs(orientations, turns.spans());
}

TEST(JudgeAhrsTest, AGoodOneFitsWhateverItsHeadingAndRate) {
    const auto turned = [](double t_s) {
        return base::rotation_from_vector({0, 0, 1.0}) * q_world_body(t_s);
    };
    EXPECT_EQ(judged(turned).fault, AhrsFault::None);
    EXPECT_EQ(judged(turned, 0.1).fault, AhrsFault::None);
}

TEST(JudgeAhrsTest, NoiseAndDriftAreNoContradiction) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    const auto noisy = [&](double t_s) {
        const Eigen::Vector3d noise(normal(random), normal(random), normal(random));
        return base::rotation_from_vector({0, 0, 0.002 * t_s}) * q_world_body(t_s) *
               base::rotation_from_vector(0.003 * noise);
    };
    const AhrsJudgement judgement = judged(noisy);
    EXPECT_EQ(judgement.fault, AhrsFault::None);
    EXPECT_TRUE(judgement.wrong_times.empty());
}

TEST(JudgeAhrsTest, FindsTheTimeInWhichItIsThatOfAnotherDive) {
    const auto partly = [](double t_s) {
        return q_world_body(t_s, t_s > 15.0 && t_s < 35.0 ? 11.0 : 0.0);
    };
    const AhrsJudgement judgement = judged(partly);
    EXPECT_EQ(judgement.fault, AhrsFault::None);
    ASSERT_FALSE(judgement.wrong_times.empty());
    double wrong_s = 0.0;
    for (const types::TimeInterval& time : judgement.wrong_times) {
        EXPECT_GT(1e-9 * static_cast<double>(time.to_ns), 15.0);
        EXPECT_LT(1e-9 * static_cast<double>(time.from_ns), 35.0);
        wrong_s += 1e-9 * static_cast<double>(time.to_ns - time.from_ns);
    }
    EXPECT_GT(wrong_s, 12.0);
    EXPECT_LT(wrong_s, 34.0);
}

TEST(JudgeAhrsTest, NamesTheInverse) {
    EXPECT_EQ(judged([](double t_s) { return q_world_body(t_s).conjugate(); }).fault,
              AhrsFault::Inverse);
}

TEST(JudgeAhrsTest, NamesTheOrderOfTheNumbers) {
    const auto scalar_last = [](double t_s) {
        const Eigen::Quaterniond q = q_world_body(t_s);
        return Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w());
    };
    EXPECT_EQ(judged(scalar_last).fault, AhrsFault::ScalarLast);
}

TEST(JudgeAhrsTest, NamesAxes) {
    const auto exchanged = [](double t_s) {
        const Eigen::Quaterniond q = q_world_body(t_s);
        return Eigen::Quaterniond(q.w(), q.y(), q.x(), -q.z());
    };
    const AhrsJudgement judgement = judged(exchanged);
    EXPECT_EQ(judgement.fault, AhrsFault::AsGyroscope);
    EXPECT_EQ(judgement.rotation.fault, GyroscopeFault::Rotated);
}

TEST(JudgeAhrsTest, NamesTheClock) {
    const AhrsJudgement judgement = judged([](double t_s) { return q_world_body(t_s - 0.5); });
    EXPECT_EQ(judgement.fault, AhrsFault::AsGyroscope);
    EXPECT_EQ(judgement.rotation.fit, GyroscopeFit::FitsShifted);
    EXPECT_NEAR(judgement.rotation.time_offset_s, 0.5, 0.02);
}

TEST(JudgeAhrsTest, AnotherDiveContradicts) {
    EXPECT_NE(judged([](double t_s) { return q_world_body(t_s, 17.0); }).fault, AhrsFault::None);
}

TEST(JudgeAhrsTest, NoneIsNotJudged) { EXPECT_EQ(judge_ahrs({}, {}).fault, AhrsFault::None); }

}  // namespace
}  // namespace divemesh::imu
