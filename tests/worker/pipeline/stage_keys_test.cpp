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
                                                        {"mesher", "marching_cubes"},
                                                        {"marker_family", "tag25h9"},
                                                        {"exports", "kitti"},
                                                        {"across_frames", "off"},
                                                        {"color", "restored"},
                                                        {"white_point", "1.9,2.1,2.4"}};

// Returns a valid value of an option that differs from `value`.
nlohmann::json other_value(const std::string& name, const nlohmann::json& value) {
    if (kOtherWords.contains(name)) return kOtherWords.at(name);
    if (value.is_boolean()) return !value.get<bool>();
    if (name == "num_disparities_px") return 64;
    if (name == "max_width_px") return 0;
    if (value.is_number_integer()) return value.get<int>() == 2 ? 1 : value.get<int>() + 1;
    return name == "simplify" ? 0.5 : 0.123;
}

StageKeys keys_of(const ReconstructionOptions& options,
                  const std::string& program = "1.0",
                  const std::string& dive = "dive") {
    return stage_keys(specs_of(reconstruction_stages()), program, dive, options);
}

StageKeys keys_with(const nlohmann::json& overrides) {
    return keys_of(make_options("standard", overrides));
}

// Returns the overrides without which nothing reads an option.
nlohmann::json overrides_to_read(const std::string& option) {
    nlohmann::json overrides = nlohmann::json::object();
    if (option == "white_point") overrides["color"] = "restored";
    return overrides;
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

// The options that a stage gets depend on nothing but what its key holds.
TEST(StageKeysTest, AStageSeesOfLaterStagesOptionsTheirDefaultsAlone) {
    const auto specs = specs_of(reconstruction_stages());
    const ReconstructionOptions options = make_options("standard",
                                                       {{"num_features", 400},
                                                        {"voxel_m", 0.05},
                                                        {"max_sigma_m", 0.02},
                                                        {"color", "restored"},
                                                        {"num_threads", 3}});
    const auto known_to = [&](const std::string& name) {
        const auto stage = std::ranges::find(specs, name, &StageSpec::name);
        return options_known_to(static_cast<std::size_t>(stage - specs.begin()), specs, options);
    };
    EXPECT_EQ(known_to("align").num_features, ReconstructionOptions().num_features);
    EXPECT_EQ(known_to("align").num_threads, 3);
    EXPECT_EQ(known_to("track").num_features, 400);
    EXPECT_EQ(known_to("optimise").voxel_m, 0.0);
    EXPECT_EQ(known_to("fuse").voxel_m, 0.05);
    EXPECT_EQ(known_to("fuse").max_sigma_m, 0.0);
    EXPECT_EQ(known_to("mesh").color, "raw");
    EXPECT_EQ(known_to("color").color, "restored");
    EXPECT_EQ(known_to("evaluate"), options);
}

TEST(StageKeysTest, WhatChangesNoByteChangesNoKey) {
    const StageKeys plain = keys_with(nlohmann::json::object());
    const StageKeys other = keys_with({{"num_threads", 1}, {"fusion_memory_bytes", 1 << 26}});

    EXPECT_EQ(other.at("track"), plain.at("track"));
    EXPECT_EQ(other.at("texture"), plain.at("texture"));
}

// Returns the names of the stages that leave files, in order.
std::vector<std::string> kept_stages() {
    std::vector<std::string> names;
    for (const StageSpec& spec : specs_of(reconstruction_stages()))
        if (!spec.files.empty()) names.push_back(spec.name);
    return names;
}

TEST(StageKeysTest, EveryOtherOptionChangesTheLastKey) {
    const std::string last = kept_stages().back();
    const nlohmann::json values = options_to_json(preset_options("standard"));
    int num_options = 0;
    for (const auto& [name, value] : values.items()) {
        if (std::ranges::count(kOptionsOfTheMachine, name) > 0) continue;
        if (name == "exports") continue;  // made from artifacts, after all stages
        if (name.starts_with("marker_")) continue;
        nlohmann::json other = values;
        other.update(overrides_to_read(name));
        const std::string plain = keys_with(other).at(last);
        other[name] = other_value(name, value);
        EXPECT_NE(keys_with(other).at(last), plain) << name;
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

TEST(StageKeysTest, RestoredColoursChangeNoStageUpToTheMesh) {
    const StageKeys raw = keys_with(nlohmann::json::object());
    const StageKeys restored = keys_with({{"color", "restored"}});

    for (const char* stage : {"align", "track", "optimise", "markers", "fuse", "mesh"})
        EXPECT_EQ(restored.at(stage), raw.at(stage)) << stage;
    EXPECT_NE(restored.at("texture"), raw.at("texture"));
}

TEST(StageKeysTest, AWhitePointChangesRestoredColoursAlone) {
    const StageKeys restored = keys_with({{"color", "restored"}});
    const StageKeys like_before =
        keys_with({{"color", "restored"}, {"white_point", "1.9,2.1,2.4"}});

    EXPECT_EQ(like_before.at("mesh"), restored.at("mesh"));
    EXPECT_NE(like_before.at("color"), restored.at("color"));
    EXPECT_NE(like_before.at("texture"), restored.at("texture"));
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

    ASSERT_GE(kept_stages().size(), 6U);
    for (const std::string& stage : kept_stages())
        EXPECT_EQ(exported.at(stage), plain.at(stage)) << stage;
}

TEST(StageKeysTest, AnOptionChangesTheKeysFromTheStageThatNamesItOn) {
    const nlohmann::json values = options_to_json(preset_options("standard"));
    const auto specs = specs_of(reconstruction_stages());
    int num_options = 0;
    for (const StageSpec& named_by : specs)
        for (const std::string& option : named_by.reads) {
            nlohmann::json overrides = overrides_to_read(option);
            const StageKeys plain = keys_with(overrides);
            overrides[option] = other_value(option, values.at(option));
            const StageKeys keys = keys_with(overrides);
            bool changed = false;
            for (const StageSpec& stage : specs) {
                changed = changed || stage.name == named_by.name;
                EXPECT_EQ(keys.at(stage.name) != plain.at(stage.name), changed)
                    << option << " in " << stage.name;
            }
            ++num_options;
        }
    EXPECT_GT(num_options, 25);
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
