#include "schemas/reconstruction_options.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh {
namespace {

TEST(ReconstructionOptions, AnOverrideReplacesOnlyItsOwnOption) {
    auto expected = preset_options("paper");
    expected.voxel_m = 0.01;
    EXPECT_EQ(make_options("paper", {{"voxel_m", 0.01}}), expected);
}

TEST(ReconstructionOptions, UnknownNamesAndImpossibleValuesAreRefusedByName) {
    EXPECT_THROW(make_options("standard", {{"voxel", 0.01}}), Error);
    EXPECT_THROW(make_options("standard", {{"voxel_m", -1.0}}), Error);
    EXPECT_THROW(make_options("standard", {{"voxel_m", "big"}}), Error);
    EXPECT_THROW(make_options("best", nlohmann::json::object()), Error);
}

TEST(ReconstructionOptions, OptionsOfEveryPresetSurviveTheWayThroughJson) {
    for (const auto preset : kPresets) {
        const auto options = preset_options(preset);
        EXPECT_EQ(make_options("standard", options_to_json(options)), options) << preset;
    }
}

}  // namespace
}  // namespace divemesh
