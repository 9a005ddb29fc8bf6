#include "cli/preset_options.hpp"

#include <gtest/gtest.h>

#include <array>

#include "schemas/error.hpp"
#include "schemas/reconstruction_options.hpp"

namespace divemesh::cli {
namespace {

TEST(PresetOptionsTest, ReadsNumbersSwitchesAndWords) {
    EXPECT_EQ(
        overrides_of({"voxel_m=0.01", "use_imu=false", "mesher=marching_cubes", "a=b=c"}),
        (nlohmann::json{
            {"voxel_m", 0.01}, {"use_imu", false}, {"mesher", "marching_cubes"}, {"a", "b=c"}}));
}

TEST(PresetOptionsTest, TakesThreeNumbersWithCommasAsAWord) {
    const nlohmann::json overrides = overrides_of({"color=restored", "white_point=1.9,2.1,2.4"});
    EXPECT_EQ(overrides, (nlohmann::json{{"color", "restored"}, {"white_point", "1.9,2.1,2.4"}}));
    EXPECT_EQ(white_point_of(make_options("standard", overrides)),
              (std::array<double, 3>{1.9, 2.1, 2.4}));
}

TEST(PresetOptionsTest, RefusesWhatHasNoNameOrNoValue) {
    EXPECT_THROW(overrides_of({"voxel_m"}), Error);
    EXPECT_THROW(overrides_of({"=1"}), Error);
}

}  // namespace
}  // namespace divemesh::cli
