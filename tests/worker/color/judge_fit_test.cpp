#include "worker/color/judge_fit.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/worker/color/water_world.hpp"

namespace divemesh::color {
namespace {

const FitEvidence kGood{
    .has_converged = true, .lit_share = {1.0, 1.0, 1.0}, .median_color = {0.2, 0.2, 0.2}};

ColorFit good_fit() {
    ColorFit fit;
    fit.channels = green_water();
    for (ChannelFit& channel : fit.channels) {
        channel.attenuation_per_m.sigma = 0.01;
        channel.explained_share = 0.9;
    }
    fit.near_m = 1.0;
    fit.far_m = 4.0;
    return fit;
}

FitOutcome judged(ColorFit fit, const FitEvidence& evidence = kGood) {
    judge_fit(evidence, fit);
    return fit.outcome;
}

TEST(JudgeFit, AcceptsWhatIsWellKnown) { EXPECT_EQ(judged(good_fit()), FitOutcome::Estimated); }

TEST(JudgeFit, TellsADarkChannelFromAVagueOne) {
    FitEvidence dark = kGood;
    dark.lit_share[0] = 0.05;
    ColorFit fit = good_fit();
    judge_fit(dark, fit);
    EXPECT_EQ(fit.outcome, FitOutcome::ChannelTooDark);
    EXPECT_FALSE(fit.channels[0].known);
    EXPECT_TRUE(fit.channels[1].known);
    EXPECT_NEAR(fit.explained_share, 0.9, 1e-9);
    fit = good_fit();
    fit.channels[0].attenuation_per_m.sigma = 0.3;
    EXPECT_EQ(judged(fit), FitOutcome::TooLittleRange);
    EXPECT_EQ(judged(fit, dark), FitOutcome::ChannelTooDark);
    for (ChannelFit& channel : fit.channels) channel.attenuation_per_m.sigma = 0.3;
    EXPECT_EQ(judged(fit), FitOutcome::TooLittleRange);
    EXPECT_EQ(judged(fit, dark), FitOutcome::TooLittleRange);
}

TEST(JudgeFit, DoesNotKnowAChannelWithoutASigma) {
    for (const double sigma :
         {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
        ColorFit fit = good_fit();
        fit.channels[2].attenuation_per_m.sigma = sigma;
        EXPECT_EQ(judged(fit), FitOutcome::TooLittleRange);
        fit = good_fit();
        fit.channels[2].far_backscatter_sigma = sigma;
        EXPECT_EQ(judged(fit), FitOutcome::TooLittleRange);
    }
}

TEST(JudgeFit, DoesNotKnowAChannelWithVagueBackscatter) {
    ColorFit fit = good_fit();
    fit.channels[1].far_backscatter_sigma = 0.1;
    EXPECT_EQ(judged(fit), FitOutcome::TooLittleRange);
}

TEST(JudgeFit, RefusesWaterThatAddsToTheLight) {
    ColorFit fit = good_fit();
    fit.channels[0].attenuation_per_m = {-0.1, 0.01};
    EXPECT_EQ(judged(fit), FitOutcome::NotExplained);
    fit.channels[0].attenuation_per_m = {-0.01, 0.001};  // it may be that of pure water and noise
    EXPECT_EQ(judged(fit), FitOutcome::Estimated);
}

TEST(JudgeFit, RefusesAFitWithoutAMinimum) {
    FitEvidence evidence = kGood;
    evidence.has_converged = false;
    EXPECT_EQ(judged(good_fit(), evidence), FitOutcome::NotConverged);
    evidence = kGood;
    evidence.is_at_bound[1] = true;
    EXPECT_EQ(judged(good_fit(), evidence), FitOutcome::NotConverged);
}

TEST(JudgeFit, RefusesWaterThatExplainsLittle) {
    ColorFit fit = good_fit();
    for (ChannelFit& channel : fit.channels) channel.explained_share = 0.05;
    EXPECT_EQ(judged(fit), FitOutcome::NotExplained);
    for (ChannelFit& channel : fit.channels) channel.attenuation_per_m.value = 0.01;
    EXPECT_EQ(judged(fit), FitOutcome::NothingToRestore);
}

}  // namespace
}  // namespace divemesh::color
