#include "worker/pipeline/color_metrics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "schemas/verdict.hpp"
#include "tests/worker/pipeline/known_water.hpp"

namespace divemesh::pipeline {
namespace {

using nlohmann::json;

TEST(ColorMetrics, TellEverythingOfKnownWater) {
    json metrics = to_metrics(known_water());
    // With the errors of the model: 0.05 per metre and a fifth of the coefficient.
    for (const auto& [channel, sigma] : {std::pair{"red", std::hypot(0.011, 0.05 + 0.2 * 0.55)},
                                         std::pair{"green", std::hypot(0.012, 0.05 + 0.2 * 0.27)},
                                         std::pair{"blue", std::hypot(0.013, 0.05 + 0.2 * 0.32)}})
        EXPECT_DOUBLE_EQ(metrics[channel]["attenuation_per_m"]["sigma"].get<double>(), sigma);
    EXPECT_DOUBLE_EQ(metrics["red"]["backscatter_per_m"]["sigma"].get<double>(),
                     std::hypot(0.021, 0.05 + 0.2 * 0.41));
    for (const char* channel : {"red", "green", "blue"})
        for (const char* coefficient : {"attenuation_per_m", "backscatter_per_m"})
            metrics[channel][coefficient].erase("sigma");

    EXPECT_EQ(metrics, json::parse(R"({
        "outcome": "estimated", "restored": true, "light": "mixed",
        "num_points": 5120, "num_sightings": 40960, "num_lost_images": 3, "near_m": 0.84, "far_m": 4.53,
        "explained_share": 0.71, "vignetting": 0.21,
        "red": {
            "attenuation_per_m": {"value": 0.55},
            "backscatter_per_m": {"value": 0.41},
            "veil": {"value": 0.03, "sigma": 0.001},
            "lamp": {"value": 0.8, "sigma": 0.12},
            "explained_share": 0.9},
        "green": {
            "attenuation_per_m": {"value": 0.27},
            "backscatter_per_m": {"value": 0.26},
            "veil": {"value": 0.19, "sigma": 0.002},
            "lamp": {"value": 0.6, "sigma": 0.13},
            "explained_share": 0.7},
        "blue": {
            "attenuation_per_m": {"value": 0.32},
            "backscatter_per_m": {"value": 0.29},
            "veil": {"value": 0.18, "sigma": 0.003},
            "lamp": {"value": 0.7, "sigma": 0.14},
            "explained_share": 0.5},
        "white_point": [1.9, 2.1, 2.4], "limited_share": 0.125})"));
}

TEST(ColorMetrics, TellOfLampsOnlyWhereLightIsMixed) {
    for (const auto light : kLightSources) {
        const json metrics = to_metrics(known_water(light));
        EXPECT_EQ(metrics["light"], color::to_string(light));
        for (const char* channel : {"red", "green", "blue"})
            EXPECT_EQ(metrics[channel].contains("lamp"), light == color::LightSource::Mixed);
    }
}

TEST(ColorMetrics, TellWhatWasFittedThoughItIsNotUsed) {
    WaterColor water = known_water();
    water.fit.outcome = color::FitOutcome::NotExplained;
    json expected = to_metrics(known_water());
    expected["outcome"] = "not_explained";
    expected["restored"] = false;
    expected.erase("white_point");
    expected.erase("limited_share");

    EXPECT_EQ(to_metrics(water), expected);
}

TEST(ColorMetrics, LeaveOutTheChannelsWhoseWaterIsNotKnown) {
    WaterColor water = known_water();
    water.fit.outcome = color::FitOutcome::ChannelTooDark;
    water.fit.channels[0].known = false;
    const json metrics = to_metrics(water);
    EXPECT_FALSE(metrics.contains("red"));
    EXPECT_TRUE(metrics.contains("green") && metrics.contains("blue"));
}

TEST(ColorMetrics, TellOnlyWhatWasSeenWhereNothingWasFitted) {
    WaterColor water;
    water.fit.outcome = color::FitOutcome::TooLittleRange;
    water.fit.num_points = 250;
    water.fit.num_sightings = 1200;
    water.fit.near_m = 1.94;
    water.fit.far_m = 2.06;

    EXPECT_EQ(to_metrics(water), json::parse(R"({
        "outcome": "too_little_range", "restored": false,
        "num_points": 250, "num_sightings": 1200, "num_lost_images": 0, "near_m": 1.94, "far_m": 2.06})"));
}

TEST(ColorFinding, SaysNothingOfColoursThatAreRestored) {
    EXPECT_FALSE(color_finding(known_water()));
}

Finding finding_on(const color::ColorFit& fit) {
    return color_finding({.fit = fit}).value_or(Finding{});
}

TEST(ColorFinding, TellsWhatWasMeasuredOfWaterThatIsNotKnown) {
    using color::FitOutcome;
    const std::pair<color::ColorFit, std::string> told[] = {
        {{.outcome = FitOutcome::TooFewSightings, .num_points = 42}, "only 42 of the sampled"},
        {{.outcome = FitOutcome::TooLittleRange, .near_m = 1.94, .far_m = 2.06},
         "from 1.9 to 2.1 m"},
        {{.outcome = FitOutcome::NothingToRestore, .near_m = 0.84, .far_m = 4.53},
         "from 0.8 to 4.5 m"},
        {{.outcome = FitOutcome::NotExplained, .explained_share = 0.07}, "explains 7 % of"},
        {{.outcome = FitOutcome::ChannelTooDark,
          .channels = {color::ChannelFit{}, {.known = true}, {.known = true}}},
         "too little light is left in red to tell"},
        {{.outcome = FitOutcome::NotConverged, .near_m = 0.84, .far_m = 4.53},
         "from 0.8 to 4.5 m"}};
    for (const auto& [fit, text] : told) {
        const Finding finding = finding_on(fit);
        EXPECT_EQ(finding.code, "color_not_restored");
        EXPECT_EQ(finding.severity, Severity::Warning);
        EXPECT_TRUE(finding.message.starts_with("the colours stay as recorded")) << finding.message;
        EXPECT_NE(finding.message.find(text), std::string::npos) << finding.message;
    }
}

TEST(ColorFinding, NamesImagesThatCouldNotBeRead) {
    const color::ColorFit fit{.outcome = color::FitOutcome::TooFewSightings, .num_points = 42};
    const Finding finding = color_finding({.fit = fit, .num_lost_images = 7}).value_or(Finding{});
    EXPECT_NE(finding.message.find("; the images of 7 keyframes could not be read"),
              std::string::npos)
        << finding.message;
    EXPECT_EQ(finding.remedy, "check the disks and reconstruct again");
    EXPECT_EQ(finding_on(fit).message.find("could not be read"), std::string::npos);
}

TEST(ColorFinding, TellsOfASurfaceThatIsRestoredInPart) {
    WaterColor color{.fit = {.outcome = color::FitOutcome::Estimated}};
    color.limited_share = 0.1;
    EXPECT_FALSE(color_finding(color));
    color.limited_share = 0.42;
    const auto finding = color_finding(color);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->code, "color_partly_restored");
    EXPECT_NE(finding->message.find("42 %"), std::string::npos) << finding->message;
    EXPECT_TRUE(restrictions_of({*finding}).empty());
}

TEST(ColorFinding, HasARemedyOfItsOwnForEveryOutcomeAndRestrictsNothing) {
    std::set<std::string> remedies;
    for (const auto outcome : kFailedOutcomes) {
        const Finding finding = finding_on({.outcome = outcome});
        EXPECT_FALSE(finding.remedy.empty()) << color::to_string(outcome);
        EXPECT_TRUE(restrictions_of({finding}).empty());
        remedies.insert(finding.remedy);
    }
    EXPECT_EQ(remedies.size(), std::size(kFailedOutcomes));
}

}  // namespace
}  // namespace divemesh::pipeline
