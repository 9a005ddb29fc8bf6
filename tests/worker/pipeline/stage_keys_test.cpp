#include "worker/pipeline/stage_keys.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "worker/pipeline/reconstruction_stages.hpp"

namespace divemesh::pipeline {
namespace {

const std::map<std::string, std::string> kOtherWords = {{"stereo", "block"},
                                                        {"correct_scale", "off"},
                                                        {"estimator", "pairwise"},
                                                        {"fusion", "octree"},
                                                        {"mesher", "marching_cubes"}};

StageKeys keys_of(const ReconstructionOptions& options,
                  const std::string& program = "1.0",
                  const std::string& dive = "dive") {
    return stage_keys(specs_of(reconstruction_stages()), program, dive, options);
}

StageKeys keys_with(const nlohmann::json& overrides) {
    return keys_of(make_options("standard", overrides));
}

TEST(StageKeysTest, AnOptionChangesTheKeysFromTheStageOnThatReadsIt) {
    const StageKeys plain = keys_with(nlohmann::json::object());

    const StageKeys voxel = keys_with({{"voxel_m", 0.05}});
    EXPECT_EQ(voxel.at("track"), plain.at("track"));
    EXPECT_EQ(voxel.at("optimise"), plain.at("optimise"));
    EXPECT_NE(voxel.at("fuse"), plain.at("fuse"));
    EXPECT_NE(voxel.at("mesh"), plain.at("mesh"));
    EXPECT_NE(voxel.at("texture"), plain.at("texture"));

    const StageKeys cut = keys_with({{"max_sigma_m", 0.02}});
    EXPECT_EQ(cut.at("fuse"), plain.at("fuse"));
    EXPECT_NE(cut.at("mesh"), plain.at("mesh"));

    EXPECT_NE(keys_with({{"num_features", 400}}).at("track"), plain.at("track"));
    EXPECT_NE(keys_with({{"refine_lenses", false}}).at("optimise"), plain.at("optimise"));
    EXPECT_EQ(keys_with({{"texture", false}}).at("mesh"), plain.at("mesh"));
    EXPECT_NE(keys_with({{"texture", false}}).at("texture"), plain.at("texture"));
}

TEST(StageKeysTest, WhatChangesNoByteChangesNoKey) {
    const StageKeys plain = keys_with(nlohmann::json::object());
    const StageKeys other = keys_with({{"num_threads", 1}, {"fusion_memory_bytes", 1 << 26}});

    EXPECT_EQ(other.at("track"), plain.at("track"));
    EXPECT_EQ(other.at("texture"), plain.at("texture"));
}

TEST(StageKeysTest, EveryOtherOptionChangesTheLastKey) {
    const ReconstructionOptions options = preset_options("standard");
    const auto texture = keys_of(options).at("texture");
    const nlohmann::json values = options_to_json(options);
    int num_options = 0;
    for (const auto& [name, value] : values.items()) {
        if (std::ranges::count(kOptionsOfTheMachine, name) > 0) continue;
        if (name == "exports") continue;  // made from artifacts, after all stages
        if (name.starts_with("marker_")) continue;
        nlohmann::json other = values;
        if (kOtherWords.contains(name))
            other[name] = kOtherWords.at(name);
        else if (value.is_boolean())
            other[name] = !value.get<bool>();
        else if (name == "num_disparities_px")
            other[name] = 64;
        else if (value.is_number_integer())
            other[name] = value.get<int>() == 2 ? 1 : value.get<int>() + 1;
        else
            other[name] = name == "simplify" ? 0.5 : 0.123;
        EXPECT_NE(keys_with(other).at("texture"), texture) << name;
        ++num_options;
    }
    EXPECT_GT(num_options, 20);
}

TEST(StageKeysTest, MarkersChangeTheMapWhereItIsScaledByThem) {
    const StageKeys plain = keys_with({{"correct_scale", "off"}});
    const StageKeys scaled = keys_with({{"correct_scale", "on"}});
    const nlohmann::json family = {{"correct_scale", "off"}, {"marker_family", "tag25h9"}};
    const nlohmann::json scaled_by_family = {{"correct_scale", "on"}, {"marker_family", "tag25h9"}};

    EXPECT_EQ(keys_with(family).at("fuse"), plain.at("fuse"));
    EXPECT_EQ(keys_with(family).at("texture"), plain.at("texture"));
    EXPECT_EQ(scaled.at("optimise"), plain.at("optimise"));
    EXPECT_NE(scaled.at("fuse"), plain.at("fuse"));
    EXPECT_NE(keys_with(scaled_by_family).at("fuse"), scaled.at("fuse"));
    EXPECT_EQ(keys_with(scaled_by_family).at("optimise"), plain.at("optimise"));
}

TEST(StageKeysTest, AnotherDiveOrVersionSharesNothing) {
    const auto options = preset_options("standard");
    const auto plain = keys_of(options).at("track");

    EXPECT_NE(keys_of(options, "1.1").at("track"), plain);
    EXPECT_NE(keys_of(options, "1.0", "another").at("track"), plain);
}

TEST(StageKeysTest, ExportsChangeNothingThatIsKept) {
    const StageKeys plain = keys_with(nlohmann::json::object());
    const StageKeys exported = keys_with({{"exports", "kitti"}});

    for (const char* stage : {"track", "optimise", "fuse", "mesh", "texture"})
        EXPECT_EQ(exported.at(stage), plain.at(stage)) << stage;
}

// The first stage that runs again if an option of the standard table changes, for each option.
TEST(StageKeysTest, EveryOptionIsFirstReadByTheStageThatNamesIt) {
    const std::map<std::string, std::pair<nlohmann::json, std::string>> others = {
        {"align_cameras", {false, "align"}},
        {"stereo", {"block", "track"}},
        {"num_disparities_px", {64, "track"}},
        {"num_features", {400, "track"}},
        {"max_width_px", {0, "track"}},
        {"estimator", {"pairwise", "track"}},
        {"use_imu", {false, "track"}},
        {"use_ahrs", {false, "track"}},
        {"use_pressure", {false, "track"}},
        {"close_loops", {false, "track"}},
        {"align_imu", {false, "track"}},
        {"surface", {false, "track"}},
        {"map_step", {0.5, "track"}},
        {"seed", {2, "track"}},
        {"adjust_whole_dive", {false, "optimise"}},
        {"refine_lenses", {false, "optimise"}},
        {"correct_scale", {"on", "markers"}},
        {"fusion", {"octree", "fuse"}},
        {"voxel_m", {0.05, "fuse"}},
        {"max_depth_m", {3.0, "fuse"}},
        {"cloud_spacing_m", {0.05, "fuse"}},
        {"mesher", {"marching_cubes", "fuse"}},
        {"max_sigma_m", {0.01, "mesh"}},
        {"simplify", {0.5, "mesh"}},
        {"simplify_error_m", {0.01, "mesh"}},
        {"texture", {false, "texture"}}};
    const StageKeys plain = keys_with(nlohmann::json::object());

    for (const auto& [option, other] : others) {
        const StageKeys keys = keys_with({{option, other.first}});
        bool changed = false;
        for (const StageSpec& stage : specs_of(reconstruction_stages())) {
            changed = changed || stage.name == other.second;
            EXPECT_EQ(keys.at(stage.name) != plain.at(stage.name), changed)
                << option << " in " << stage.name;
        }
    }
}

TEST(StageKeysTest, AnOptionThatNoStageNamesCountsAsReadByTheFirst) {
    const std::vector<StageSpec> stages = {{.name = "one"}, {.name = "two", .reads = {"simplify"}}};
    const auto keys = [&](const nlohmann::json& overrides) {
        return stage_keys(stages, "1.0", "dive", make_options("standard", overrides));
    };
    const StageKeys plain = keys(nlohmann::json::object());

    EXPECT_NE(keys({{"mesher", "marching_cubes"}}).at("one"), plain.at("one"));
    EXPECT_EQ(keys({{"simplify", 0.5}}).at("one"), plain.at("one"));
    EXPECT_NE(keys({{"simplify", 0.5}}).at("two"), plain.at("two"));
}

}  // namespace
}  // namespace divemesh::pipeline
