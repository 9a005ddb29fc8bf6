#include "worker/stage_keys.hpp"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

namespace divemesh::worker {
namespace {

const std::map<std::string, std::string> kOtherWords = {{"stereo", "block"},
                                                        {"estimator", "pairwise"},
                                                        {"fusion", "octree"},
                                                        {"mesher", "marching_cubes"}};

StageKeys keys_with(const nlohmann::json& overrides) {
    return stage_keys("1.0", "dive", make_options("standard", overrides));
}

TEST(StageKeysTest, AnOptionChangesTheKeysFromTheStageOnThatReadsIt) {
    const StageKeys plain = keys_with(nlohmann::json::object());

    const StageKeys voxel = keys_with({{"voxel_m", 0.05}});
    EXPECT_EQ(voxel.track, plain.track);
    EXPECT_EQ(voxel.optimise, plain.optimise);
    EXPECT_NE(voxel.fuse, plain.fuse);
    EXPECT_NE(voxel.mesh, plain.mesh);
    EXPECT_NE(voxel.texture, plain.texture);

    const StageKeys mesher = keys_with({{"mesher", "marching_cubes"}});
    EXPECT_EQ(mesher.fuse, plain.fuse);
    EXPECT_NE(mesher.mesh, plain.mesh);

    EXPECT_NE(keys_with({{"num_features", 400}}).track, plain.track);
    EXPECT_NE(keys_with({{"refine_lenses", false}}).optimise, plain.optimise);
    EXPECT_EQ(keys_with({{"texture", false}}).mesh, plain.mesh);
    EXPECT_NE(keys_with({{"texture", false}}).texture, plain.texture);
}

TEST(StageKeysTest, WhatChangesNoByteChangesNoKey) {
    const StageKeys plain = keys_with(nlohmann::json::object());
    const StageKeys other = keys_with({{"num_threads", 1}, {"fusion_memory_bytes", 1 << 26}});

    EXPECT_EQ(other.track, plain.track);
    EXPECT_EQ(other.texture, plain.texture);
}

TEST(StageKeysTest, EveryOtherOptionChangesTheLastKey) {
    const ReconstructionOptions options = preset_options("standard");
    const auto texture = stage_keys("1.0", "dive", options).texture;
    const nlohmann::json values = options_to_json(options);
    int num_options = 0;
    for (const auto& [name, value] : values.items()) {
        if (name == "num_threads" || name == "fusion_memory_bytes") continue;
        if (name == "exports") continue;  // made of artifacts, after all stages
        if (name.starts_with("marker_")) continue;
        nlohmann::json other = values;
        if (kOtherWords.contains(name))
            other[name] = kOtherWords.at(name);
        else if (value.is_boolean())
            other[name] = !value.get<bool>();
        else if (name == "num_disparities_px")
            other[name] = 64;
        else if (value.is_number_integer())
            other[name] = value.get<int>() + 1;
        else
            other[name] = name == "simplify" ? 0.5 : 0.123;
        EXPECT_NE(stage_keys("1.0", "dive", make_options("standard", other)).texture, texture)
            << name;
        ++num_options;
    }
    EXPECT_GT(num_options, 20);
}

TEST(StageKeysTest, MarkersChangeTheMapWhereItIsScaledByThem) {
    const StageKeys plain = keys_with(nlohmann::json::object());
    const StageKeys scaled = keys_with({{"correct_scale", true}});
    const nlohmann::json family = {{"marker_family", "tag25h9"}};
    const nlohmann::json scaled_by_family = {{"correct_scale", true}, {"marker_family", "tag25h9"}};

    EXPECT_EQ(keys_with(family).fuse, plain.fuse);
    EXPECT_EQ(keys_with(family).texture, plain.texture);
    EXPECT_EQ(scaled.optimise, plain.optimise);
    EXPECT_NE(scaled.fuse, plain.fuse);
    EXPECT_NE(keys_with(scaled_by_family).fuse, scaled.fuse);
    EXPECT_EQ(keys_with(scaled_by_family).optimise, plain.optimise);
}

TEST(StageKeysTest, AnotherDiveOrVersionSharesNothing) {
    const auto options = preset_options("standard");
    const auto plain = stage_keys("1.0", "dive", options).track;

    EXPECT_NE(stage_keys("1.1", "dive", options).track, plain);
    EXPECT_NE(stage_keys("1.0", "another", options).track, plain);
}

}  // namespace
}  // namespace divemesh::worker
