#include "tests/bench/judge.hpp"

#include <gtest/gtest.h>

namespace divemesh::bench {
namespace {

using nlohmann::json;

json run_of(const std::string& dive, const std::string& metric, double value) {
    return {{"group", "trajectory"},
            {"dive", dive},
            {"preset", "standard"},
            {"ablation", "none"},
            {"metrics", {{metric, value}}}};
}

Goal goal_over(Goal::Over over, bool at_most, double value) {
    return {"trajectory", {"a", "b", "c", "d"}, "standard", "x", over, at_most, value};
}

const json kRuns = {
    run_of("a", "x", 1.0), run_of("b", "x", -4.0), run_of("c", "x", 3.0), run_of("d", "x", 2.0)};

TEST(JudgeTest, TheMedianOfAnEvenNumberIsTheMeanOfTheMiddleTwo) {
    const json judged = judge(goal_over(Goal::Over::Median, true, 2.5), kRuns);
    EXPECT_EQ(judged["measured"], 2.5);
    EXPECT_EQ(judged["met"], true);
}

TEST(JudgeTest, TheMeanIsOverAbsoluteValues) {
    EXPECT_EQ(judge(goal_over(Goal::Over::Mean, true, 2.5), kRuns)["measured"], 2.5);
    EXPECT_EQ(judge(goal_over(Goal::Over::Mean, false, 2.6), kRuns)["met"], false);
}

TEST(JudgeTest, TheWorstIsTheLargestOfWhatShallBeSmallAndTheSmallestOfWhatShallBeLarge) {
    EXPECT_EQ(judge(goal_over(Goal::Over::Worst, true, 3.9), kRuns)["measured"], 4.0);
    EXPECT_EQ(judge(goal_over(Goal::Over::Worst, true, 3.9), kRuns)["met"], false);
    EXPECT_EQ(judge(goal_over(Goal::Over::Worst, false, 1.0), kRuns)["measured"], 1.0);
    EXPECT_EQ(judge(goal_over(Goal::Over::Worst, false, 1.0), kRuns)["met"], true);
}

TEST(JudgeTest, AGoalWithADiveMissingOrFailedIsNotMet) {
    json runs = kRuns;
    runs[3].erase("metrics");
    const json judged = judge(goal_over(Goal::Over::Worst, true, 10.0), runs);
    EXPECT_EQ(judged["num_dives_measured"], 3);
    EXPECT_EQ(judged["met"], false);
    EXPECT_TRUE(
        judge(goal_over(Goal::Over::Worst, true, 10.0), json::array())["measured"].is_null());
}

TEST(JudgeTest, AblationsDoNotCount) {
    json runs = kRuns;
    for (json& run : runs) run["ablation"] = "imu_off";
    EXPECT_TRUE(judge(goal_over(Goal::Over::Worst, true, 10.0), runs)["measured"].is_null());
}

TEST(JudgeTest, TrackLifeIsComparedByTheMedianOfTheSimulatedBarges) {
    const std::string metric = "median_track_life_frames";
    const json runs = {run_of("barge", metric, 5.0),
                       run_of("sim-barge-1", metric, 4.0),
                       run_of("sim-barge-2", metric, 9.0),
                       run_of("sim-barge-3", metric, 6.0),
                       run_of("sim-reef-1", metric, 50.0)};
    const json life = compare_track_life(runs);
    EXPECT_DOUBLE_EQ(life["ratio"].get<double>(), 1.2);
    EXPECT_EQ(life["within_30_percent"], true);
    EXPECT_TRUE(compare_track_life(json::array({runs[0]})).is_null());
}

}  // namespace
}  // namespace divemesh::bench
