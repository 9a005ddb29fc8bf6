#include "schemas/requirement.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "schemas/metric.hpp"

namespace divemesh {
namespace {

std::string refusal(const std::string& text) {
    try {
        parse_requirement(text);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
        return error.what();
    }
    ADD_FAILURE() << text << " was taken";
    return "";
}

TEST(Requirement, AShortNameMeansTheFinalTrajectory) {
    const Requirement requirement = parse_requirement("drift_percent<=0.5");
    EXPECT_EQ(requirement.metric, "trajectory.final.drift_percent");
    EXPECT_EQ(requirement.comparison, Comparison::LessOrEqual);
    EXPECT_EQ(requirement.limit, 0.5);
    EXPECT_EQ(requirement.text, "drift_percent<=0.5");
}

TEST(Requirement, TheWholeNameSaysWhichIsMeant) {
    EXPECT_EQ(parse_requirement("trajectory.causal.ate_rmse_m<1").metric,
              "trajectory.causal.ate_rmse_m");
    EXPECT_EQ(parse_requirement("causal.ate_rmse_m<1").metric, "trajectory.causal.ate_rmse_m");
}

TEST(Requirement, BlanksAndEveryComparisonAreTaken) {
    EXPECT_EQ(parse_requirement(" coverage >= 0.99 ").comparison, Comparison::GreaterOrEqual);
    EXPECT_EQ(parse_requirement("coverage > 9.9e-1").comparison, Comparison::Greater);
    EXPECT_EQ(parse_requirement("surface.accuracy.median_m < +0.01").comparison, Comparison::Less);
}

TEST(Requirement, LimitsAreHeldAsTheirSignSays) {
    EXPECT_TRUE(is_met(parse_requirement("ate_rmse_m<=0.02"), 0.02));
    EXPECT_FALSE(is_met(parse_requirement("ate_rmse_m<0.02"), 0.02));
    EXPECT_TRUE(is_met(parse_requirement("coverage>=1"), 1.0));
    EXPECT_FALSE(is_met(parse_requirement("coverage>1"), 1.0));
}

TEST(Requirement, EntriesOfListsAreNamedByTheirLabel) {
    EXPECT_EQ(parse_requirement("segments[2].translation_mean_percent<=1").metric,
              "trajectory.final.segments[2].translation_mean_percent");
    EXPECT_EQ(parse_requirement("distances[bar <1> a.b].error_m<=0.003").metric,
              "known_distances.distances[bar <1> a.b].error_m");
}

TEST(Requirement, AMisspeltMetricIsRefusedWithTheOneThatIsMeant) {
    EXPECT_NE(refusal("drift_precent<=0.5").find("drift_percent"), std::string::npos);
    EXPECT_NE(refusal("ate_rms_m<=0.5").find("ate_rmse_m"), std::string::npos);
}

TEST(Requirement, ANameThatCouldBeSeveralMetricsListsThem) {
    const std::string message = refusal("median_m<=0.1");
    EXPECT_NE(message.find("surface.accuracy.median_m"), std::string::npos);
    EXPECT_NE(message.find("surface.completeness.median_m"), std::string::npos);
}

TEST(Requirement, WhatIsNoComparisonWithANumberIsRefused) {
    for (const char* text : {"",
                             "drift_percent",
                             "drift_percent=0.5",
                             "<=0.5",
                             "drift_percent<=",
                             "drift_percent<=half",
                             "drift_percent<=0.5%",
                             "drift_percent<=nan",
                             "drift_percent<=1e999",
                             "drift_percent=<0.5",
                             "a<=1<=2"})
        refusal(text);
    refusal(std::string(100'000, '<'));
}

TEST(FlattenMetrics, EveryNumberHasUnitMethodAndAlignment) {
    const nlohmann::json metrics = {
        {"options", {{"voxel_m", 0.01}}},
        {"frames", {{"num_frames", 700}}},
        {"trajectory",
         {{"final",
           {{"ate_rmse_m", 0.02},
            {"segments", {{{"length_m", 2.0}, {"translation_mean_percent", 0.3}}}}}}}},
        {"known_distances", {{"distances", {{{"name", "bar"}, {"measured_m", nullptr}}}}}}};

    const auto flattened = flatten_metrics(metrics);

    ASSERT_EQ(flattened.size(), 5U);
    const auto named = [&](const std::string& name) {
        return *std::find_if(flattened.begin(), flattened.end(), [&](const Metric& metric) {
            return metric.name == name;
        });
    };
    EXPECT_EQ(named("trajectory.final.ate_rmse_m").value, 0.02);
    EXPECT_EQ(named("trajectory.final.ate_rmse_m").unit, "m");
    EXPECT_NE(named("trajectory.final.ate_rmse_m").alignment.find("SE(3)"), std::string::npos);
    const Metric segment = named("trajectory.final.segments[2].translation_mean_percent");
    EXPECT_EQ(segment.unit, "%");
    EXPECT_EQ(segment.alignment, "none: relative");
    EXPECT_FALSE(segment.method.empty());
    EXPECT_EQ(named("frames.num_frames").unit, "1");
    EXPECT_FALSE(named("known_distances.distances[bar].measured_m").value);
}

TEST(FlattenMetrics, EntriesOfAMetricInheritItsUnit) {
    const nlohmann::json metrics = {
        {"calibration", {{"refined", {{"time_offset_s", {{"value", 0.01}, {"sigma", 1e-4}}}}}}}};
    const auto flattened = flatten_metrics(metrics);
    ASSERT_EQ(flattened.size(), 2U);
    for (const Metric& metric : flattened) EXPECT_EQ(metric.unit, "s") << metric.name;
}

TEST(FlattenMetrics, EntriesWithTheSameNameStayDistinct) {
    const nlohmann::json metrics = {
        {"known_distances",
         {{"distances",
           {{{"name", "bar"}, {"known_m", 1.0}}, {{"name", "bar"}, {"known_m", 2.0}}}}}}};
    const auto flattened = flatten_metrics(metrics);
    ASSERT_EQ(flattened.size(), 2U);
    EXPECT_NE(flattened[0].name, flattened[1].name);
}

}  // namespace
}  // namespace divemesh
