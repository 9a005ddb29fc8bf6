#include "tests/bench/envelope_summary.hpp"

#include <gtest/gtest.h>

#include "tests/bench/envelope_plot.hpp"
#include "tests/bench/envelope_table.hpp"

namespace divemesh::bench {
namespace {

using nlohmann::json;

json run_of(const char* step, double ate_m, double tracked_share) {
    return {{"axis", "rate"},
            {"step", step},
            {"scene", "barge"},
            {"seed", 1},
            {"exit_code", 0},
            {"tracked_share", tracked_share},
            {"path_m", 10.0},
            {"ate_m", ate_m},
            {"bound_m", 0.02},
            {"scale", 0.99},
            {"verdict", nullptr},
            {"findings", {"imu_missing"}},
            {"sift", {{"linked_share", 0.75}, {"ate_m", nullptr}, {"scale", nullptr}}}};
}

EnvelopeAxis axis() {
    EnvelopeAxis axis{.name = "rate"};
    for (const char* step : {"10 Hz", "1 Hz", "never run"})
        axis.steps.push_back({.label = step, .rendered = {}, .options = {}, .change = {}});
    return axis;
}

json rows() {
    return summarise(axis(),
                     {run_of("10 Hz", 0.01, 1.0),
                      run_of("10 Hz", 0.03, 1.0),
                      run_of("10 Hz", 0.2, 0.5),
                      run_of("1 Hz", 0.04, 0.1)});
}

TEST(EnvelopeSummaryTest, StepHasMedianAndWorstOfItsRunsInPercentOfThePath) {
    ASSERT_EQ(rows().size(), 2U);
    const json row = rows()[0];
    EXPECT_EQ(row["num_runs"], 3);
    EXPECT_EQ(row["num_working"], 2);
    EXPECT_NEAR(row["ate_percent"]["median"].get<double>(), 0.3, 1e-12);
    EXPECT_NEAR(row["ate_percent"]["worst"].get<double>(), 2.0, 1e-12);
    EXPECT_NEAR(row["lost_share"]["worst"].get<double>(), 0.5, 1e-12);
    EXPECT_NEAR(row["scale_error_percent"]["median"].get<double>(), 1.0, 1e-9);
    EXPECT_NEAR(row["sift_unlinked_share"]["median"].get<double>(), 0.25, 1e-12);
    EXPECT_TRUE(row["sift_ate_percent"]["median"].is_null());
    EXPECT_EQ(row["findings"]["imu_missing"], 3);
}

TEST(EnvelopeSummaryTest, TableHasARowPerStepWithWhatWasSaidAndADashForWhatWasNot) {
    const json report = {
        {"num_runs", 4},
        {"edges", {{{"axis", "rate"}, {"last_good", nullptr}, {"first_bad", "10 Hz"}}}},
        {"steps", rows()},
        {"beyond", json::array()},
        {"silent", json::array()},
        {"hollow", json::array()}};
    const std::string table = envelope_table(report);
    EXPECT_NE(table.find("| rate | - | 10 Hz |"), std::string::npos) << table;
    EXPECT_NE(table.find("| rate | 10 Hz | 2/3 | 0 (50) | 0.30 (2.00) | 0.20 | 1.00 | 25 | - | "
                         "imu_missing x3 |"),
              std::string::npos)
        << table;
}

TEST(EnvelopeSummaryTest, PlotHasAPanelForAnAxisThatWasRunAndNoneForAnother) {
    const std::string plot = envelope_plot(rows(), {"rate", "snow"});
    EXPECT_NE(plot.find(">rate</text>"), std::string::npos);
    EXPECT_EQ(plot.find(">snow</text>"), std::string::npos);
    EXPECT_NE(plot.find(">1 Hz</text>"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::bench
