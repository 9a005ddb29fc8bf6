#include "worker/pipeline/reconstruction_stages.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "schemas/job.hpp"
#include "tests/paths.hpp"
#include "worker/pipeline/stage_keys.hpp"

namespace divemesh::pipeline {
namespace {

using Names = std::vector<std::string>;

TEST(ReconstructionStagesTest, AJobHasTheSameStagesAndIsPublishedInTheEnd) {
    Names expected;
    for (const StageSpec& stage : specs_of(reconstruction_stages()))
        if (stage.part_of.empty()) expected.push_back(stage.name);
    expected.push_back("publish");

    EXPECT_EQ(Names(kStageNames.begin(), kStageNames.end()), expected);
}

TEST(ReconstructionStagesTest, TheSchemaOfTheMetricsHasTheSameStages) {
    std::ifstream stream(source_directory() / "schemas/metrics.schema.json");
    const auto schema = nlohmann::json::parse(stream);
    const auto names = schema.at(nlohmann::json::json_pointer(
        "/properties/speed/properties/stages/items/properties/stage/enum"));
    Names expected;
    for (const StageSpec& stage : specs_of(reconstruction_stages())) expected.push_back(stage.name);

    EXPECT_EQ(names.get<Names>(), expected);
}

TEST(ReconstructionStagesTest, EveryOptionIsReadFirstByOneStageOrByTheMachine) {
    std::map<std::string, int> num_readers;
    for (const StageSpec& stage : specs_of(reconstruction_stages()))
        for (const std::string& option : stage.reads) ++num_readers[option];
    for (const std::string_view option : kOptionsOfTheMachine) ++num_readers[std::string(option)];
    std::map<std::string, int> once;
    const nlohmann::json options = options_to_json({});
    for (const auto& option : options.items()) once[option.key()] = 1;

    EXPECT_EQ(num_readers, once);
}

TEST(ReconstructionStagesTest, ColoursAreRestoredBetweenMeshAndTexture) {
    const std::vector<StageSpec> specs = specs_of(reconstruction_stages());
    const auto color = std::ranges::find(specs, "color", &StageSpec::name);
    ASSERT_TRUE(color != specs.begin() && color != specs.end());

    EXPECT_EQ(std::prev(color)->name, "mesh");
    EXPECT_EQ(std::next(color)->name, "texture");
    EXPECT_EQ(color->part_of, "texture") << "a job has no such stage";
    EXPECT_EQ(color->reads, (Names{"color", "white_point"}));
    ASSERT_NE(color->reads_count, nullptr);
    EXPECT_FALSE(color->reads_count(make_options("standard", {{"color", "raw"}})));
    EXPECT_TRUE(color->reads_count(make_options("standard", {{"color", "restored"}})));
}

TEST(ReconstructionStagesTest, TheSharesOfTheProgressAreOneWhole) {
    double whole = 0.0;
    for (const StageSpec& stage : specs_of(reconstruction_stages())) whole += stage.share;

    EXPECT_NEAR(whole, 1.0, 1e-12);
}

TEST(ReconstructionStagesTest, WhatAStageLeavesIsItsOwnAndIsBothSavedAndLoaded) {
    Names files;
    for (const Stage<Reconstruction>& stage : reconstruction_stages()) {
        EXPECT_NE(stage.run, nullptr) << stage.spec.name;
        EXPECT_EQ(stage.load != nullptr, !stage.spec.files.empty()) << stage.spec.name;
        EXPECT_EQ(stage.save != nullptr, !stage.spec.files.empty()) << stage.spec.name;
        files.insert(files.end(), stage.spec.files.begin(), stage.spec.files.end());
    }
    ASSERT_FALSE(files.empty());
    std::ranges::sort(files);
    EXPECT_EQ(std::ranges::adjacent_find(files), files.end());
}

}  // namespace
}  // namespace divemesh::pipeline
