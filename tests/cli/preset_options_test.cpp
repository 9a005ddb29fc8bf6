#include "cli/preset_options.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh::cli {
namespace {

TEST(PresetOptionsTest, ReadsNumbersSwitchesAndWords) {
    EXPECT_EQ(
        overrides_of({"voxel_m=0.01", "use_imu=false", "mesher=marching_cubes", "a=b=c"}),
        (nlohmann::json{
            {"voxel_m", 0.01}, {"use_imu", false}, {"mesher", "marching_cubes"}, {"a", "b=c"}}));
}

TEST(PresetOptionsTest, RefusesWhatHasNoNameOrNoValue) {
    EXPECT_THROW(overrides_of({"voxel_m"}), Error);
    EXPECT_THROW(overrides_of({"=1"}), Error);
}

}  // namespace
}  // namespace divemesh::cli
