#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <memory>

#include "tests/synthetic/true_change.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/compare/coarse_alignment.hpp"
#include "worker/compare/compare.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"

namespace divemesh::compare {
namespace {

using nlohmann::json;

constexpr double kLength_m = 2.5;

// Simulates a dive with small images of a reef in clear water.
void dive(const std::filesystem::path& folder, std::uint64_t seed, int year) {
    const simulator::SimulateOptions options{.scene = simulator::SceneKind::Reef,
                                             .out = folder / "dive",
                                             .length_m = kLength_m,
                                             .rate_hz = 4.0,
                                             .seed = seed,
                                             .water = simulator::WaterKind::Clear,
                                             .year = year,
                                             .snow = false,
                                             .fish = false,
                                             .width_px = 400,
                                             .height_px = 300,
                                             .num_markers = 6,
                                             .marker_size_m = 0.16};
    simulator::simulate(options);
    pipeline::reconstruct_dive({.dive = folder / "dive",
                                .out = folder / "model",
                                .scratch = folder / "scratch",
                                .resumable = false,
                                .options = make_options("standard", json::object())},
                               base::ignore_progress);
}

// Dives of two years over one reef with six boards.
class ComparedDives : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        dive(*folder_ / "first", 1, 1);
        dive(*folder_ / "second", 1, 2);
    }
    static void TearDownTestSuite() { folder_.reset(); }

    static json compare(const std::string& model) {
        return compare_reconstructions({.a = *folder_ / "first" / model,
                                        .b = *folder_ / "second" / model,
                                        .out = *folder_ / ("out_" + model)});
    }
    static std::filesystem::path truth_of(const std::string& year) {
        return *folder_ / year / "dive/mav0/state_groundtruth_estimate0/data.csv";
    }
    // Returns the pose of the reconstruction's world in the scene, aligned over the whole path.
    static Eigen::Isometry3d T_scene_world(const std::string& year) {
        return evaluation::trajectory_error(
                   io::read_trajectory(*folder_ / year / "model" / "trajectory.tum").poses,
                   io::read_trajectory(truth_of(year)).poses)
            .T_reference_surface;
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(ComparedDives, WhatGrewAndWhatWasLostLiesWithinItsInterval) {
    for (const char* year : {"first", "second"}) {  // the markers are left out
        const auto bare = *folder_ / year / "bare";
        std::filesystem::copy(
            *folder_ / year / "model", bare, std::filesystem::copy_options::recursive);
        json metrics = json::parse(std::ifstream(bare / "metrics.json"));
        metrics.erase("markers");
        std::ofstream(bare / "metrics.json") << metrics;
    }
    const json document = compare("bare");
    const auto truth =
        synthetic::TrueChange(simulator::make_scene(simulator::SceneKind::Reef, 1, 1, kLength_m),
                              simulator::make_scene(simulator::SceneKind::Reef, 1, 2, kLength_m),
                              *folder_ / "first/model",
                              truth_of("first"),
                              *folder_ / "out_bare")
            .all();
    const auto expect_within = [&](const char* kind, double volume_m3) {
        const json& interval = document.at(kind).at("volume_m3");
        EXPECT_LE(interval.at("low").get<double>(), volume_m3) << kind << interval;
        EXPECT_GE(interval.at("high").get<double>(), volume_m3) << kind << interval;
    };
    expect_within("grown", truth.grown_m3);
    expect_within("lost", truth.lost_m3);
    EXPECT_GE(document.at("patches").size(), 1U);
    EXPECT_NE(document["registration"]["method"], "markers");
}

TEST_F(ComparedDives, MarkersTellWhereTheLaterYearLies) {
    const auto markers = [](const char* year) {
        return marker_positions(io::ReconstructionFolder(*folder_ / year / "model"));
    };
    const auto coarse_alignments = align_by_markers(markers("first"), markers("second"));
    ASSERT_EQ(coarse_alignments.size(), 1U);
    EXPECT_GE(coarse_alignments[0].score, 3.0);
    const Eigen::Isometry3d T_true = T_scene_world("first").inverse() * T_scene_world("second");
    const auto expect_near_truth = [&](const Eigen::Isometry3d& T_a_b, double max_m) {
        for (const MarkerPosition& marker : markers("second"))
            EXPECT_LT((T_a_b * marker.p_world - T_true * marker.p_world).norm(), max_m)
                << marker.id;
    };
    expect_near_truth(coarse_alignments[0].T_a_b, 0.02);

    const json fit = compare("model")["registration"];
    EXPECT_EQ(fit["method"], "markers");
    const auto p = fit["T_a_b"]["position_m"].get<std::array<double, 3>>();
    const auto q = fit["T_a_b"]["orientation_wxyz"].get<std::array<double, 4>>();
    Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
    T_a_b.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    T_a_b.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
    expect_near_truth(T_a_b, 0.015);
}

TEST_F(ComparedDives, BoardsLieWhereTheyWereLaidInTheFirstYear) {
    const auto bars = [](const char* year) {
        std::map<std::string, double> lengths_m;
        const json plan = json::parse(std::ifstream(*folder_ / year / "dive/markers.json"));
        for (const json& bar : plan.at("scale_bars")) lengths_m[bar["name"]] = bar["distance_m"];
        return lengths_m;
    };
    const auto first = bars("first");
    EXPECT_EQ(first.size(), 9U);
    int num_shared = 0;
    for (const auto& [name, length_m] : bars("second")) {
        if (!first.contains(name)) continue;  // at a board that was removed
        EXPECT_EQ(length_m, first.at(name)) << name;
        ++num_shared;
    }
    EXPECT_GE(num_shared, 3);
}

}  // namespace
}  // namespace divemesh::compare
