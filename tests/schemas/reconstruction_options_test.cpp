#include "schemas/reconstruction_options.hpp"

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/invalid_input.hpp"

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

// Returns what is wrong with overrides; empty if they are accepted.
std::vector<Fault> faults_of(const nlohmann::json& overrides) {
    try {
        make_options("standard", overrides);
        return {};
    } catch (const InvalidInput& refused) {
        return refused.faults();
    }
}

void expect_one_fault(const nlohmann::json& overrides,
                      const std::string& pointer,
                      const std::string& detail) {
    const std::vector<Fault> faults = faults_of(overrides);
    ASSERT_EQ(faults.size(), 1U) << overrides;
    EXPECT_EQ(faults[0].pointer, pointer);
    EXPECT_EQ(faults[0].detail, detail);
}

TEST(ReconstructionOptions, ColoursAreRawUnlessTheyAreToBeRestored) {
    for (const auto preset : kPresets) EXPECT_EQ(preset_options(preset).color, "raw") << preset;
    for (const std::string color : {"raw", "restored"})
        EXPECT_EQ(make_options("standard", {{"color", color}}).color, color);
    for (const std::string color : {"", "Raw", "restored ", "true"})
        expect_one_fault({{"color", color}},
                         "/color",
                         "option color is \"" + color + "\"; it must be one of: raw, restored");
    expect_one_fault({{"color", true}}, "/color", "option color has the wrong type: true");
}

std::optional<std::array<double, 3>> white_point_from(const std::string& text) {
    ReconstructionOptions options;
    options.white_point = text;
    return white_point_of(options);
}

TEST(ReconstructionOptions, AWhitePointIsThreeNumbersAsInMetrics) {
    const std::pair<std::string, std::array<double, 3>> good[] = {
        {"1.9,2.1,2.4", {1.9, 2.1, 2.4}},
        {"1.8973665961010275,2,3", {1.8973665961010275, 2.0, 3.0}},
        {"0.01,1,1000", {0.01, 1.0, 1000.0}}};
    for (const auto& [text, numbers] : good) {
        EXPECT_EQ(white_point_from(text), numbers) << text;
        const auto options =
            make_options("standard", {{"color", "restored"}, {"white_point", text}});
        EXPECT_EQ(options.white_point, text);
        EXPECT_FALSE(faults_of({{"white_point", text}}).empty()) << "raw colours do not read it";
    }
    EXPECT_FALSE(white_point_from(""));
    EXPECT_TRUE(faults_of({{"color", "restored"}, {"white_point", ""}}).empty());
}

TEST(ReconstructionOptions, AWhitePointThatIsNotThreeNumbersInRangeIsRefused) {
    for (const std::string text :
         {"2",         "1.9,2.1",   "1,2,3,4", "white",   "1,2,x",      "1,2,3x",
          "0,1,1",     "1,-2,1",    "nan,1,1", "1,inf,1", "1,1,0.0099", "1001,1,1",
          "1,1,1e999", ",",         "1,2,3,",  ",1,2,3",  "1,,2",       "1,2,",
          "1;2;3",     "1.9.1,2,3", " ",       "1, 2, 3", " 1,2,3",     "1,2,3 "}) {
        EXPECT_FALSE(white_point_from(text)) << text;
        for (const char* color : {"raw", "restored"})
            expect_one_fault({{"color", color}, {"white_point", text}},
                             "/white_point",
                             "option white_point must be empty (from the dive) or three numbers "
                             "from 0.01 to 1000, such as 1.9,2.1,2.4");
    }
    EXPECT_EQ(faults_of({{"color", "grey"}, {"white_point", "grey"}}).size(), 2U);
}

TEST(ReconstructionOptions, AWhitePointIsTextEvenInJson) {
    expect_one_fault(
        {{"white_point", 1.5}}, "/white_point", "option white_point has the wrong type: 1.5");
    expect_one_fault({{"white_point", nlohmann::json::array({1.5, 2.5, 3.5})}},
                     "/white_point",
                     "option white_point has the wrong type: [1.5,2.5,3.5]");
}

}  // namespace
}  // namespace divemesh
