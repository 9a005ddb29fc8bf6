#include "cli/import_kind.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh::cli {
namespace {

// Returns why the options are refused; "" if they are not.
std::string refusal(const std::vector<std::string>& given, ImportKind kind) {
    try {
        check_options_apply(given, kind, "REEF");
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
        return error.what();
    }
    return "";
}

TEST(ImportKindTest, OptionsThatApplyPass) {
    EXPECT_EQ(refusal({"--out", "--left", "--right", "--imu"}, ImportKind::Messages), "");
    EXPECT_EQ(refusal({"--layout", "--offset", "--rate", "--imu"}, ImportKind::Videos), "");
    EXPECT_EQ(refusal({"--left", "--rate", "--list", "--unit", "--bits"}, ImportKind::Images), "");
    EXPECT_EQ(refusal({"--calibration", "--calibration-unit", "--image-size"},
                      ImportKind::CalibrationAlone),
              "");
}

TEST(ImportKindTest, ARefusalNamesTheOptionWhatWasFoundAndWhatApplies) {
    const std::string text = refusal({"--out", "--layout"}, ImportKind::Images);

    for (const char* part :
         {"--layout", "videos", "REEF is a folder of images", "--left", "--list"})
        EXPECT_NE(text.find(part), std::string::npos) << part << ": " << text;
}

TEST(ImportKindTest, WhatOneKindAloneUsesIsRefusedForTheOthers) {
    EXPECT_NE(refusal({"--left"}, ImportKind::Videos), "");
    EXPECT_NE(refusal({"--rate"}, ImportKind::Messages), "");
    EXPECT_NE(refusal({"--bayer"}, ImportKind::Messages), "");
    EXPECT_NE(refusal({"--offset"}, ImportKind::Messages), "");
    EXPECT_NE(refusal({"--image-size"}, ImportKind::Videos), "");
    EXPECT_NE(refusal({"--imu"}, ImportKind::CalibrationAlone), "");
}

}  // namespace
}  // namespace divemesh::cli
