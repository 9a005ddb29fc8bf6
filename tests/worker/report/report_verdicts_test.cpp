#include "worker/report/report_verdicts.hpp"

#include <gtest/gtest.h>

namespace divemesh::report {
namespace {

using nlohmann::json;

std::vector<Metric> metrics() {
    return {{"trajectory.final.drift_percent", 0.4, "%", "", ""},
            {"frames.coverage", 0.5, "1", "", ""},
            {"known_distances.distances[bar].error_m", std::nullopt, "m", "", ""}};
}

json judged(const std::vector<std::string>& texts) {
    std::vector<Requirement> requirements;
    for (const std::string& text : texts) requirements.push_back(parse_requirement(text));
    return judge_requirements(requirements, metrics());
}

TEST(Verdicts, AMetricWithinItsLimitIsMet) {
    const json verdicts = judged({"drift_percent<=0.4"});
    EXPECT_EQ(verdicts[0]["met"], true);
    EXPECT_EQ(verdicts[0]["reason"], "");
    EXPECT_EQ(passed(verdicts), json(true));
}

TEST(Verdicts, OneThatIsNotMetFailsTheReportAndSaysTheValue) {
    const json verdicts = judged({"drift_percent<=0.5", "coverage>=0.99"});
    EXPECT_EQ(verdicts[1]["met"], false);
    EXPECT_EQ(verdicts[1]["reason"], "it is 0.5");
    EXPECT_EQ(passed(verdicts), json(false));
}

TEST(Verdicts, WhatIsNotToBeHadIsNotMetAndSaysWhatIsMissing) {
    for (const char* text : {"surface.accuracy.median_m<=1", "distances[bar].error_m<=1"}) {
        const json verdicts = judged({text});
        EXPECT_EQ(verdicts[0]["met"], false);
        EXPECT_TRUE(verdicts[0]["value"].is_null());
        EXPECT_NE(verdicts[0]["reason"].get<std::string>().find("not available"),
                  std::string::npos);
    }
}

TEST(Verdicts, NoRequirementOnAResultThatIsNotUsableIsMet) {
    const std::vector<Requirement> requirements = {parse_requirement("drift_percent<=0.5"),
                                                   parse_requirement("coverage>=0.99")};
    const json verdicts = judge_requirements(requirements, metrics(), "it is not usable");
    for (const json& verdict : verdicts) {
        EXPECT_EQ(verdict["met"], false);
        EXPECT_EQ(verdict["reason"], "it is not usable");
    }
    EXPECT_EQ(verdicts[0]["value"], 0.4);
    EXPECT_EQ(passed(verdicts), json(false));
}

TEST(Verdicts, NothingAskedIsNeitherPassedNorFailed) { EXPECT_TRUE(passed(judged({})).is_null()); }

TEST(Regressions, AMetricThatIsWorseThanItsHistoryAllowsIsNamed) {
    const std::string drift = "trajectory.final.drift_percent";
    EXPECT_EQ(find_regressions({{drift, {0.20, 0.21, 0.19, 0.2}}}, metrics()).size(), 1U);
    EXPECT_EQ(find_regressions({{drift, {0.38, 0.4, 0.39}}}, metrics()).size(), 0U);
    EXPECT_EQ(find_regressions({{drift, {0.1, 0.7, 0.3}}}, metrics()).size(), 0U);  // wide
}

TEST(Regressions, AShareThatFellIsWorseAndOneThatRoseIsNot) {
    EXPECT_EQ(find_regressions({{"frames.coverage", {0.99, 1.0, 1.0}}}, metrics()).size(), 1U);
    EXPECT_EQ(find_regressions({{"frames.coverage", {0.2, 0.2, 0.2}}}, metrics()).size(), 0U);
}

TEST(Regressions, AnErrorIsAsBadAsItIsLargeWhateverItsSign) {
    const auto regressions = [](double earlier, double now) {
        const std::string name = "known_distances.distances[bar].error_m";
        return find_regressions({{name, {earlier, earlier, earlier}}},
                                {{.name = name, .value = now}});
    };
    EXPECT_TRUE(regressions(-0.002, 0.0002).empty());
    EXPECT_TRUE(regressions(-0.002, 0.002).empty());
    ASSERT_EQ(regressions(0.001, -0.004).size(), 1U);
    EXPECT_DOUBLE_EQ(regressions(0.001, -0.004)[0]["value"].get<double>(), 0.004);
}

TEST(Regressions, WhatADiveIsLikeAndHowFastTheMachineWasIsNotJudged) {
    for (const std::string name : {"frames.num_keyframes",
                                   "trajectory.path_length_m",
                                   "calibration.gravity.tilt_deg",
                                   "calibration.refined.lenses.cam0.k1.sigma",
                                   "surface.accuracy.num_samples",
                                   "speed.stages[track].wall_s"})
        EXPECT_TRUE(
            find_regressions({{name, {1.0, 1.0, 1.0}}}, {{.name = name, .value = 9.0}}).empty())
            << name;
}

TEST(Regressions, TwoEarlierValuesSayNothing) {
    EXPECT_TRUE(find_regressions({{"frames.coverage", {1.0, 1.0}}}, metrics()).empty());
}

}  // namespace
}  // namespace divemesh::report
