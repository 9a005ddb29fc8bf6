#include "worker/dive/ahrs_jumps.hpp"

#include <gtest/gtest.h>

#include "worker/base/angle.hpp"

namespace divemesh::dive {
namespace {

constexpr int kNumRows = 400;  // at 20 Hz

// A rig that rolls and turns by up to 1 rad/s.
Eigen::Quaterniond truth(int row) {
    const double t_s = 0.05 * row;
    return Eigen::AngleAxisd(0.8 * std::sin(t_s), Eigen::Vector3d::UnitZ()) *
           Eigen::Quaterniond(
               Eigen::AngleAxisd(0.3 * std::sin(2.0 * t_s), Eigen::Vector3d::UnitX()));
}

// Returns the rows of an AHRS whose heading is off by `heading_deg(row)`.
template <typename Heading>
std::vector<types::OrientationSample> rows(const Heading& heading_deg) {
    std::vector<types::OrientationSample> samples;
    for (int i = 0; i < kNumRows; ++i)
        samples.push_back(
            {50'000'000LL * i,
             Eigen::AngleAxisd(base::kRadPerDeg * heading_deg(i), Eigen::Vector3d::UnitZ()) *
                 truth(i)});
    return samples;
}

double worst_deg(const std::vector<types::OrientationSample>& samples) {
    double worst = 0.0;
    for (int i = 0; i < kNumRows; ++i)
        worst = std::max(
            worst, samples[static_cast<std::size_t>(i)].q_world_imu.angularDistance(truth(i)));
    return base::kDegPerRad * worst;
}

TEST(AhrsJumpsTest, AHeadingThatJumpsIsTurnedBack) {
    auto samples = rows([](int i) { return i < 150 ? 0.0 : i < 300 ? 30.0 : -170.0; });
    FindingLog log;
    take_off_ahrs_jumps(samples, "ahrs", log);
    // What the rig turned from one row to the next is lost twice.
    EXPECT_LT(worst_deg(samples), 2.0 * base::kDegPerRad * 0.05 * 1.0 + 0.1);
    ASSERT_EQ(log.all().size(), 1U);
    EXPECT_EQ(log.all()[0].code, "ahrs_jump");
    EXPECT_NE(log.all()[0].message.find("jumps 2 times, by up to 1"), std::string::npos)
        << log.all()[0].message;
}

TEST(AhrsJumpsTest, ASingleWrongRowGoesOnWhereItWas) {
    auto samples = rows([](int i) { return i == 200 ? 90.0 : 0.0; });
    FindingLog log;
    take_off_ahrs_jumps(samples, "ahrs", log);
    EXPECT_LT(worst_deg(samples), 2.0 * base::kDegPerRad * 0.05 * 1.0 + 0.1);
}

TEST(AhrsJumpsTest, FastTurnsDriftAndShuffledRowsStayAsTheyAre) {
    for (const bool shuffled : {false, true}) {
        auto samples =
            rows([&](int i) { return shuffled ? 40.0 * (i % 2) : 3.0 * std::sin(0.02 * i); });
        const auto before = samples;
        FindingLog log;
        take_off_ahrs_jumps(samples, "ahrs", log);
        EXPECT_TRUE(log.all().empty());
        for (std::size_t i = 0; i < samples.size(); ++i)
            EXPECT_EQ(samples[i].q_world_imu.coeffs(), before[i].q_world_imu.coeffs());
    }
}

}  // namespace
}  // namespace divemesh::dive
