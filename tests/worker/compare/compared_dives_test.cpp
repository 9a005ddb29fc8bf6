#include <gtest/gtest.h>

#include "schemas/error.hpp"
#include "tests/synthetic/true_change.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/compare/compare.hpp"
#include "worker/reconstruct_dive.hpp"

namespace divemesh::worker {
namespace {

using nlohmann::json;

constexpr double kLength_m = 2.5;

// Small pictures of a reef in clear water.
void dive(const std::filesystem::path& folder, std::uint64_t seed, int year) {
    const SimulateOptions options{.scene = SceneKind::Reef,
                                  .out = folder / "dive",
                                  .length_m = kLength_m,
                                  .rate_hz = 4.0,
                                  .seed = seed,
                                  .water = WaterKind::Clear,
                                  .year = year,
                                  .snow = false,
                                  .fish = false,
                                  .width_px = 400,
                                  .height_px = 300};
    simulate(options);
    reconstruct_dive({.dive = folder / "dive",
                      .out = folder / "model",
                      .scratch = folder / "scratch",
                      .resumable = false,
                      .options = make_options("standard", json::object())},
                     ignore_progress);
}

TEST(ComparedDives, WhatGrewAndWhatWasLostLiesWithinItsInterval) {
    const TemporaryFolder folder;
    dive(folder / "first", 1, 1);
    dive(folder / "second", 1, 2);
    const json document = compare_reconstructions(
        {.a = folder / "first/model", .b = folder / "second/model", .out = folder / "out"});
    const auto truth =
        synthetic::TrueChange(make_scene(SceneKind::Reef, 1, 1, kLength_m),
                              make_scene(SceneKind::Reef, 1, 2, kLength_m),
                              folder / "first/model",
                              folder / "first/dive/mav0/state_groundtruth_estimate0/data.csv",
                              folder / "out")
            .all();
    const auto expect_within = [&](const char* kind, double volume_m3) {
        const json& interval = document.at(kind).at("volume_m3");
        EXPECT_LE(interval.at("low").get<double>(), volume_m3) << kind << interval;
        EXPECT_GE(interval.at("high").get<double>(), volume_m3) << kind << interval;
    };
    expect_within("grown", truth.grown_m3);
    expect_within("lost", truth.lost_m3);
    EXPECT_GE(document.at("patches").size(), 1U);
}

}  // namespace
}  // namespace divemesh::worker
