#include "worker/pipeline/result_findings.hpp"

#include <gtest/gtest.h>

#include "schemas/verdict.hpp"

namespace divemesh::pipeline {
namespace {

TEST(SegmentsFindingTest, TellsNumberAndLengths) {
    EXPECT_FALSE(segments_finding({{.num_frames = 5, .path_length_m = 1.0}}));
    const auto finding = segments_finding(
        {{.num_frames = 120, .path_length_m = 12.1}, {.num_frames = 40, .path_length_m = 3.25}});
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->code, "dive_in_segments");
    EXPECT_NE(finding->message.find("2 segments of 12.10 m (120 frames), 3.25 m (40 frames)"),
              std::string::npos)
        << finding->message;
}

TEST(ScaleFindingTest, AnySensorOrKnownLengthTestsTheScale) {
    evaluation::ExpectedAccuracy expected;
    ASSERT_TRUE(scale_finding(expected));
    EXPECT_EQ(scale_finding(expected)->code, "scale_untested");
    expected.scales.push_back({"markers", {}});
    EXPECT_FALSE(scale_finding(expected));
}

TEST(ScaleUncertaintyFindingTest, TellsHowLittleIsKnownOfAllLengths) {
    evaluation::ExpectedAccuracy expected;
    EXPECT_FALSE(scale_uncertainty_finding(expected)) << "not known at all: bounds_unknown";
    expected.cameras = evaluation::ScaleCheck{1.0, 0.012};
    EXPECT_FALSE(scale_uncertainty_finding(expected));
    expected.cameras->sigma = 0.45;
    const auto finding = scale_uncertainty_finding(expected);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->code, "scale_uncertain");
    EXPECT_EQ(restriction_of(*finding), "scale");
    EXPECT_NE(finding->message.find("by 88 % (95 %)"), std::string::npos) << finding->message;
}

TEST(BoundsFindingTest, OnlyOfAConnectedPath) {
    evaluation::ExpectedAccuracy expected;
    EXPECT_TRUE(bounds_finding(expected, 1));
    EXPECT_FALSE(bounds_finding(expected, 2));
    expected.ate_bound_m = 0.01;
    EXPECT_FALSE(bounds_finding(expected, 1));
}

TEST(VerticalFindingTest, WarnsWhereNoSensorTellsWhichWayIsUp) {
    EXPECT_FALSE(vertical_finding(true));
    const auto finding = vertical_finding(false);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->code, "vertical_unknown");
    EXPECT_EQ(finding->severity, Severity::Warning);
    EXPECT_FALSE(finding->remedy.empty());
}

TEST(ShutterFindingTest, OnlyOfAReadoutTimeThatIsUsed) {
    types::RefinedCalibration calibration;
    calibration.readout_time_s = -0.021;
    calibration.readout_shift_px = 1.25;
    EXPECT_FALSE(shutter_finding(calibration));
    calibration.readout_time_applied = true;
    const auto finding = shutter_finding(calibration);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->code, "rolling_shutter");
    EXPECT_EQ(finding->severity, Severity::Warning);
    EXPECT_NE(finding->message.find("21.0 ms"), std::string::npos) << finding->message;
}

TEST(LeftOutFindingTest, TellsHowMuchDepthTheVoxelIsTooSmallFor) {
    const VoxelSizes voxels{0.002, 0.002, 0.002};
    ReconstructionOptions options;
    options.voxel_m = 0.002;
    const auto finding = left_out_finding({1000, 400, 180}, 2.19, voxels, options);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->code, "depth_left_out");
    EXPECT_EQ(finding->severity, Severity::Warning);
    EXPECT_NE(finding->message.find("58 % of the measured depth"), std::string::npos);
    EXPECT_NE(finding->message.find("voxels of 2 mm"), std::string::npos) << finding->message;
    EXPECT_NE(finding->message.find("40 % lies beyond 2.2 m, 18 % is nearer"), std::string::npos)
        << finding->message;
    EXPECT_NE(finding->remedy.find("without it"), std::string::npos);
    EXPECT_EQ(left_out_finding({1000, 400, 180}, 2.19, voxels, {})->remedy.find("without it"),
              std::string::npos);
}

TEST(LeftOutFindingTest, SaysNothingOfLittleDepthOrOfALimitThatWasAskedFor) {
    const VoxelSizes voxels{0.01, 0.01, 0.01};
    ReconstructionOptions options;
    EXPECT_FALSE(left_out_finding({}, 4.0, voxels, options)) << "no surface was wanted";
    EXPECT_FALSE(left_out_finding({1000, 240, 250}, 4.0, voxels, options));
    EXPECT_TRUE(left_out_finding({1000, 260, 0}, 4.0, voxels, options));
    EXPECT_TRUE(left_out_finding({1000, 0, 510}, 4.0, voxels, options));
    options.max_depth_m = 2.0;
    EXPECT_FALSE(left_out_finding({1000, 900, 40}, 2.0, voxels, options));
    EXPECT_TRUE(left_out_finding({1000, 900, 60}, 2.0, voxels, options));
}

TEST(SurfaceFindingTest, AMeshWithoutTrianglesIsAnError) {
    EXPECT_FALSE(surface_finding(1));
    ASSERT_TRUE(surface_finding(0));
    EXPECT_EQ(surface_finding(0)->severity, Severity::Error);
}

// Half of each image has depth; the mesh has surface at a share of it.
std::vector<mesh::ImageCoverage> covered(double share) {
    return std::vector<mesh::ImageCoverage>(20, {0, 0.9, 0.5, 0.5 * share});
}

TEST(IncompleteFindingTest, ADiveThatLacksAThirdIsNotSilent) {
    EXPECT_FALSE(incomplete_finding(covered(0.88), 0.0));
    EXPECT_FALSE(incomplete_finding({}, 0.0));
    const auto finding = incomplete_finding(covered(0.66), 0.0);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->code, "surface_incomplete");
    EXPECT_EQ(finding->severity, Severity::Warning);
    EXPECT_NE(finding->message.find("only 66 %"), std::string::npos) << finding->message;
    EXPECT_EQ(finding->remedy.find("max_sigma_m"), std::string::npos) << finding->remedy;
}

TEST(IncompleteFindingTest, NamesTheOptionThatCutTheSurface) {
    const auto finding = incomplete_finding(covered(0.5), 3.25);
    ASSERT_TRUE(finding);
    EXPECT_NE(finding->message.find("max_sigma_m removed 3.25 m2"), std::string::npos);
    EXPECT_NE(finding->remedy.find("larger max_sigma_m"), std::string::npos);
}

TEST(TextureFindingTest, WarnsWhereMoreThan15PercentHaveNoPhotograph) {
    EXPECT_FALSE(texture_finding({.textured_share = 0.86}, 50));
    const auto finding = texture_finding({.textured_share = 0.74}, 50);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->code, "texture_incomplete");
    EXPECT_EQ(finding->severity, Severity::Warning);
    EXPECT_TRUE(finding->message.starts_with("26 % of the area")) << finding->message;
    EXPECT_NE(finding->message.find("no keyframe shows it"), std::string::npos);
    EXPECT_NE(finding->remedy.find("swim over"), std::string::npos);
}

TEST(TextureFindingTest, NamesTheKeyframesWhoseImagesAreLost) {
    const auto finding = texture_finding({.textured_share = 0.97, .lost_frames = {12, 40}}, 50);
    ASSERT_TRUE(finding);
    EXPECT_NE(finding->message.find("2 of 50 keyframes could not be read again (frames 12, 40)"),
              std::string::npos)
        << finding->message;
    EXPECT_NE(finding->remedy.find("check the disk"), std::string::npos);
    const auto many =
        texture_finding({.textured_share = 0.97, .lost_frames = std::vector<int>(11, 5)}, 50);
    EXPECT_NE(many->message.find("5 and 3 more)"), std::string::npos) << many->message;
}

TEST(TextureFindingTest, RestrictsNothing) {
    EXPECT_TRUE(restrictions_of({*texture_finding({.textured_share = 0.5}, 50)}).empty());
}

}  // namespace
}  // namespace divemesh::pipeline
