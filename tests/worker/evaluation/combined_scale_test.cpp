#include "worker/evaluation/combined_scale.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace divemesh::evaluation {
namespace {

TEST(CombinedScaleTest, WeighsEachByWhatItKnows) {
    const CombinedScale scale =
        combined_scale({{"markers", {1.01, 0.001}}, {"accelerometer", {1.01, 0.01}}}, 0.005);
    EXPECT_TRUE(scale.differs);
    EXPECT_NEAR(scale.sensors.scale, 1.01, 1e-12);
    const double by_sensors = 1e6 + 1e4;
    const double by_cameras = 1.0 / (0.005 * 0.005);
    EXPECT_NEAR(scale.factor, 1.0 + 0.01 * by_sensors / (by_sensors + by_cameras), 1e-12);
    EXPECT_NEAR(scale.sigma, 1.0 / std::sqrt(by_sensors + by_cameras), 1e-12);
}

TEST(CombinedScaleTest, ARigThatIsNotAsCalibratedIsNotBelieved) {
    const CombinedScale scale = combined_scale({{"accelerometer", {0.96, 0.005}}}, 0.005);
    EXPECT_NEAR(scale.factor, 0.96, 1e-12);
    EXPECT_NEAR(scale.sigma, 0.005, 1e-12);
}

TEST(CombinedScaleTest, DisagreeingSensorsWidenTheSigma) {
    const CombinedScale scale =
        combined_scale({{"markers", {1.02, 0.004}}, {"accelerometer", {0.98, 0.004}}}, 0.005);
    EXPECT_FALSE(scale.differs);
    EXPECT_NEAR(scale.sensors.sigma, 0.02, 1e-9);
}

TEST(ScaleCorrectionTest, IsRefutedOnlyWhereBothTogetherCannotBeRight) {
    const auto better = scale_correction({{"markers", {1.01, 0.001}}}, 0.005);
    ASSERT_TRUE(better);
    EXPECT_FALSE(better->refuted);
    const auto wrong = scale_correction({{"markers", {1.05, 0.001}}}, 0.005);
    ASSERT_TRUE(wrong);
    EXPECT_TRUE(wrong->refuted);
    EXPECT_NEAR(wrong->factor, 1.05, 1e-12);
}

TEST(ScaleCorrectionTest, IsNotMadeWithoutReasonOrWhereASizeMustBeWrong) {
    EXPECT_FALSE(scale_correction({}, 0.005));
    EXPECT_FALSE(scale_correction({{"accelerometer", {1.008, 0.004}}}, 0.005));
    EXPECT_FALSE(scale_correction({{"markers", {1.25, 0.001}}}, 0.005));
    EXPECT_FALSE(scale_correction({{"markers", {0.8, 0.001}}}, 0.005));
    EXPECT_FALSE(scale_correction({{"markers", {1.05, 0.001}}}, 0.0));
}

// As with images of JPEG quality 8, whose right scale is 1.
TEST(ScaleCorrectionTest, IsNotMadeBySensorsThatKnowLittleWhereImagesTellLess) {
    EXPECT_FALSE(scale_correction({{"accelerometer", {0.935, 0.0325}}}, 0.047));
    EXPECT_TRUE(scale_correction({{"accelerometer", {0.86, 0.0325}}}, 0.047)) << "contradicted";
}

TEST(ScaleCorrectionTest, IsMadeWhereTheSensorsKnowItClearlyBetter) {
    const auto better = scale_correction({{"known_distances", {1.002, 0.001}}}, 0.005);
    ASSERT_TRUE(better);
    EXPECT_FALSE(better->differs);
    EXPECT_NEAR(better->factor, 1.0 + 0.002 * 25.0 / 26.0, 1e-12);
    EXPECT_LT(better->sigma, 0.001);
}

// Draws true scales by the cameras' sigma and measures them with noise.
TEST(CombinedScaleTest, TheErrorOfTheFactorMatchesItsSigma) {
    constexpr double kCameras = 0.005;
    constexpr double kSensor = 0.003;
    constexpr int kNumDraws = 2000;
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    double squares = 0.0;
    for (int i = 0; i < kNumDraws; ++i) {
        const double truth = 1.0 + kCameras * normal(random);
        const auto scale =
            combined_scale({{"markers", {truth + kSensor * normal(random), kSensor}}}, kCameras);
        squares += std::pow((scale.factor - truth) / scale.sigma, 2) / kNumDraws;
    }
    EXPECT_NEAR(squares, 1.0, 0.1);
}

}  // namespace
}  // namespace divemesh::evaluation
