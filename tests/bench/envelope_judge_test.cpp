#include "tests/bench/envelope_judge.hpp"

#include <gtest/gtest.h>

namespace divemesh::bench {
namespace {

using nlohmann::json;

json good_run() {
    return {{"step", "a"},
            {"exit_code", 0},
            {"tracked_share", 1.0},
            {"path_m", 10.0},
            {"ate_m", 0.004},
            {"bound_m", 0.006},
            {"verdict", nullptr},
            {"findings", json::array()}};
}

json with(json run, const char* field, const json& value) {
    run[field] = value;
    return run;
}

TEST(EnvelopeJudgeTest, RunWorksWithinHalfAPercentOfThePathAndNineTenthsOfTheFrames) {
    EXPECT_TRUE(works(good_run()));
    EXPECT_FALSE(works(with(good_run(), "ate_m", 0.06)));
    EXPECT_FALSE(works(with(good_run(), "ate_m", nullptr)));
    EXPECT_FALSE(works(with(good_run(), "tracked_share", 0.8)));
    EXPECT_FALSE(works(with(good_run(), "exit_code", 1)));
}

TEST(EnvelopeJudgeTest, ErrorBeyondThreeBoundsIsSilentUntilVerdictFindingOrExitCodeSaysSo) {
    EXPECT_FALSE(is_silent(good_run()));
    EXPECT_FALSE(is_silent(with(good_run(), "ate_m", 0.017)));
    const json wrong = with(good_run(), "ate_m", 0.019);
    EXPECT_TRUE(is_silent(wrong));
    EXPECT_TRUE(is_silent(with(wrong, "verdict", "good")));
    EXPECT_FALSE(is_silent(with(wrong, "verdict", "restricted")));
    EXPECT_FALSE(is_silent(with(wrong, "findings", {"scale_contradicted"})));
    EXPECT_FALSE(is_silent(with(wrong, "exit_code", 1)));
}

TEST(EnvelopeJudgeTest, AnErrorBreaksItsBoundWhateverIsSaid) {
    const json wrong = with(good_run(), "ate_m", 0.019);
    EXPECT_FALSE(breaks_bound(good_run()));
    EXPECT_TRUE(breaks_bound(wrong));
    EXPECT_TRUE(breaks_bound(with(wrong, "findings", {"scale_contradicted"})));
    EXPECT_FALSE(breaks_bound(with(wrong, "bound_m", nullptr)));
}

TEST(EnvelopeJudgeTest, WithoutABoundARunIsSilentWhenItDoesNotWork) {
    const json unstated = with(good_run(), "bound_m", nullptr);
    EXPECT_FALSE(is_silent(unstated));
    EXPECT_TRUE(is_silent(with(unstated, "tracked_share", 0.3)));
}

TEST(EnvelopeJudgeTest, SuccessWithLessThanATenthTrackedIsHollow) {
    EXPECT_TRUE(is_hollow_success(with(good_run(), "tracked_share", 0.09)));
    EXPECT_FALSE(is_hollow_success(good_run()));
    EXPECT_FALSE(is_hollow_success(with(with(good_run(), "tracked_share", 0.0), "exit_code", 1)));
}

TEST(EnvelopeJudgeTest, EdgeIsBeforeTheFirstStepThatAnyRunFails) {
    const std::vector<std::string> steps = {"a", "b", "c"};
    const json bad = with(with(good_run(), "step", "b"), "tracked_share", 0.5);
    const auto edge = [&](const std::vector<json>& runs) { return edge_of(steps, runs); };
    const json found = edge({good_run(), with(good_run(), "step", "b"), bad});
    EXPECT_EQ(found["last_good"], "a");
    EXPECT_EQ(found["first_bad"], "b");
    EXPECT_TRUE(edge({with(bad, "step", "a")})["last_good"].is_null());
    EXPECT_EQ(edge({good_run()})["last_good"], "c");
    EXPECT_TRUE(edge({good_run()})["first_bad"].is_null());
}

}  // namespace
}  // namespace divemesh::bench
