#include "worker/reconstruct_dive.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/temporary_folder.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::worker {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::set<std::string> names_in(const fs::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
    return names;
}

class ReconstructDiveTest : public testing::Test {
protected:
    ReconstructDiveTest() {
        simulate({.scene = SceneKind::Tank,
                  .out = folder_ / "dive",
                  .length_m = 0.2,
                  .rate_hz = 8.0,
                  .width_px = 160,
                  .height_px = 120});
        fs::remove(folder_ / "dive" / "reference.ply");  // a million samples take too long here
    }
    nlohmann::json reconstruct(const std::string& name, const nlohmann::json& overrides) {
        double last_fraction = 0.0;
        const auto metrics = reconstruct_dive({.dive = folder_ / "dive",
                                               .out = folder_ / name,
                                               .scratch = folder_ / (name + "-scratch"),
                                               .options = make_options("standard", overrides)},
                                              [&](const Progress& progress) {
                                                  EXPECT_GE(progress.fraction, last_fraction);
                                                  last_fraction = progress.fraction;
                                              });
        EXPECT_NEAR(last_fraction, 1.0, 1e-9);
        return metrics;
    }

    TemporaryFolder folder_;
};

TEST_F(ReconstructDiveTest, WithoutASurfaceTheTrajectoriesAreTheSameAndNothingElseIsMade) {
    const auto whole = reconstruct("whole", {{"voxel_m", 0.02}});
    const auto alone = reconstruct("alone", {{"surface", false}});
    EXPECT_EQ(names_in(folder_ / "alone"),
              (std::set<std::string>{"trajectory.tum",
                                     "trajectory_causal.tum",
                                     "trajectory_covariance.csv",
                                     "metrics.json",
                                     "report.html"}));
    for (const auto* name :
         {"trajectory.tum", "trajectory_causal.tum", "trajectory_covariance.csv"})
        EXPECT_EQ(content(folder_ / "alone" / name), content(folder_ / "whole" / name)) << name;
    EXPECT_EQ(alone["trajectory"], whole["trajectory"]);
    EXPECT_TRUE(whole.contains("mesh"));
    EXPECT_FALSE(alone.contains("mesh"));
}

}  // namespace
}  // namespace divemesh::worker
