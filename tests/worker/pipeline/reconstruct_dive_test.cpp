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
                                               .cache = cache_,
                                               .cache_bytes = std::int64_t{1} << 30,
                                               .options = make_options("standard", overrides)},
                                              [&](const Progress& progress) {
                                                  EXPECT_GE(progress.fraction, last_fraction);
                                                  last_fraction = progress.fraction;
                                              });
        EXPECT_NEAR(last_fraction, 1.0, 1e-9);
        return metrics;
    }

    std::set<std::string> reused(const nlohmann::json& metrics) {
        std::set<std::string> names;
        for (const auto& stage : metrics["speed"]["stages"])
            if (stage["reused"]) names.insert(stage["stage"]);
        return names;
    }
    void expect_same_files(const std::string& one, const std::string& other) {
        int num_compared = 0;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / one)) {
            const auto name = entry.path().lexically_relative(folder_ / one);
            if (!entry.is_regular_file() || name == "metrics.json" || name == "report.html")
                continue;  // these say how long it took
            EXPECT_EQ(content(entry.path()), content(folder_ / other / name)) << name;
            ++num_compared;
        }
        EXPECT_GT(num_compared, 3);
    }

    TemporaryFolder folder_;
    fs::path cache_;  // empty: none
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

// What is left out and what is made anew by the options that differ; the bytes are those of a run
// from nothing.
TEST_F(ReconstructDiveTest, ARunStartsWhereItDiffersFromAnEarlierOne) {
    const nlohmann::json plain = {{"voxel_m", 0.02}};
    const nlohmann::json coarse = {{"voxel_m", 0.03}};
    const nlohmann::json meshed = {
        {"voxel_m", 0.03}, {"mesher", "marching_cubes"}, {"simplify", 0.5}};
    const nlohmann::json stated = {{"voxel_m", 0.03}, {"refine_lenses", false}};
    reconstruct("fresh-coarse", coarse);
    reconstruct("fresh-meshed", meshed);
    reconstruct("fresh-stated", stated);
    cache_ = folder_ / "cache";
    EXPECT_TRUE(reused(reconstruct("first", plain)).empty());

    using Names = std::set<std::string>;
    EXPECT_EQ(reused(reconstruct("again", plain)),
              (Names{"track", "optimise", "fuse", "mesh", "texture"}));
    EXPECT_EQ(reused(reconstruct("coarse", coarse)), (Names{"track", "optimise"}));
    EXPECT_EQ(reused(reconstruct("meshed", meshed)), (Names{"track", "optimise", "fuse"}));
    EXPECT_EQ(reused(reconstruct("stated", stated)), (Names{"track"}));

    expect_same_files("first", "again");
    expect_same_files("fresh-coarse", "coarse");
    expect_same_files("fresh-meshed", "meshed");
    expect_same_files("fresh-stated", "stated");
}

}  // namespace
}  // namespace divemesh::worker
