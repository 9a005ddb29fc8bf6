#include "cli/metrics_table.hpp"

#include <gtest/gtest.h>

namespace divemesh::cli {
namespace {

TEST(MetricsTableTest, NamesEveryMetricAsTheFileDoes) {
    const nlohmann::json metrics = {
        {"frames", 12},
        {"trajectory", {{"ate_rmse_m", 0.0123456}, {"none", nullptr}}},
        {"stages", {{{"stage", "track"}, {"wall_s", 1.5}}, {{"stage", "mesh"}, {"wall_s", 2.0}}}},
        {"options", {{"voxel_m", 0.1}}}};
    EXPECT_EQ(metrics_table(metrics),
              "frames                 12\n"
              "stages[track].wall_s   1.500000\n"
              "stages[mesh].wall_s    2.000000\n"
              "trajectory.ate_rmse_m  0.012346\n");
}

TEST(MetricsTableTest, AVectorIsOneLine) {
    EXPECT_EQ(metrics_table({{"lever_arm_m", {{"vector", {0.1, -0.25, 3.0}}}}}),
              "lever_arm_m.vector  0.100000, -0.250000, 3.000000\n");
}

TEST(MetricsSummaryTest, TellsWhatIsThereInUnitsForPeople) {
    const nlohmann::json metrics = {{"frames", {{"num_frames", 84}, {"coverage", 0.9884}}},
                                    {"trajectory", {{"final", {{"ate_rmse_m", 0.00199}}}}}};
    EXPECT_EQ(metrics_summary(metrics),
              "frames                        84\n"
              "frames constrained by vision  98.8 %\n"
              "trajectory error, RMSE        2.0 mm\n");
}

TEST(MetricsSummaryTest, TellsWhatSimplifyingLost) {
    const nlohmann::json metrics = {
        {"mesh",
         {{"num_triangles", 500},
          {"simplification",
           {{"num_triangles_before", 2000}, {"rms_m", 0.0004}, {"max_m", 0.0031}}}}}};
    EXPECT_EQ(metrics_summary(metrics),
              "triangles                    500\n"
              "  before simplification      2000\n"
              "  simplification error, RMS  0.4 mm\n"
              "  simplification error, max  3.1 mm\n");
}

TEST(MetricsSummaryTest, TellsWhatIsMissingOfTheSurface) {
    const nlohmann::json metrics = {{"mesh",
                                     {{"area_m2", 12.5},
                                      {"covered_share", 0.884},
                                      {"covered_share_of_matched", 0.913},
                                      {"num_holes", 7},
                                      {"hole_area_m2", 0.0418},
                                      {"cut_by_sigma_m2", 1.25}}}};
    EXPECT_EQ(metrics_summary(metrics),
              "mesh                          12.50 m2\n"
              "  of keyframe images covered  88 %\n"
              "  of measured surface         91 %\n"
              "  holes                       7\n"
              "  area of the holes           0.042 m2\n"
              "  removed by max_sigma_m      1.250 m2\n");
}

}  // namespace
}  // namespace divemesh::cli
