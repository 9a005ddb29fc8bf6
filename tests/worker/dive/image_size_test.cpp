#include "worker/dive/image_size.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/finding_matcher.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/dive.hpp"

namespace divemesh::dive {
namespace {

types::Camera camera_of_size(int width_px, int height_px) {
    types::Camera camera;
    camera.width_px = width_px;
    camera.height_px = height_px;
    camera.fx_px = 500.0;
    camera.fy_px = 510.0;
    camera.cx_px = 320.0;
    camera.cy_px = 241.0;
    return camera;
}

struct Pixel {
    double u, v;
};

// Returns where a pinhole camera sees the point (0.1, -0.2, 1).
Pixel seen_by(const types::Camera& camera) {
    return {camera.fx_px * 0.1 + camera.cx_px, camera.fy_px * -0.2 + camera.cy_px};
}

Pixel seen_in_part(const types::Camera& calibrated, const ImageSize& size) {
    const auto part = part_of(calibrated, size);
    if (!part) throw std::invalid_argument("no part of " + to_string(size));
    const types::Camera camera = camera_of(calibrated, *part);
    EXPECT_EQ(camera.width_px, size.width_px);
    EXPECT_EQ(camera.height_px, size.height_px);
    return seen_by(camera);
}

TEST(ImageSizeTest, AHalvedImageShowsAPointInTheSquareOfFourPixels) {
    const Pixel full = seen_by(camera_of_size(640, 480));
    const Pixel half = seen_in_part(camera_of_size(640, 480), {320, 240});
    // Pixels 2 k and 2 k + 1 become pixel k, whose centre lay at 2 k + 1/2.
    EXPECT_NEAR(2.0 * half.u + 0.5, full.u, 1e-9);
    EXPECT_NEAR(2.0 * half.v + 0.5, full.v, 1e-9);
}

TEST(ImageSizeTest, RowsThatAreCutMoveAPointByHalfOfThem) {
    const Pixel full = seen_by(camera_of_size(640, 480));
    const Pixel cut = seen_in_part(camera_of_size(640, 480), {640, 360});
    EXPECT_NEAR(cut.u, full.u, 1e-9);
    EXPECT_NEAR(cut.v, full.v - 60.0, 1e-9);
}

TEST(ImageSizeTest, ColumnsThatAreCutMoveAPointByHalfOfThem) {
    const Pixel full = seen_by(camera_of_size(640, 480));
    const Pixel cut = seen_in_part(camera_of_size(640, 480), {480, 480});
    EXPECT_NEAR(cut.u, full.u - 80.0, 1e-9);
    EXPECT_NEAR(cut.v, full.v, 1e-9);
}

TEST(ImageSizeTest, AVideoOfAStillCameraIsCutThenReduced) {
    // 4:3 stills at 2560 x 1920, 16:9 video at 1280 x 720: a quarter of the rows is cut.
    types::Camera stills = camera_of_size(2560, 1920);
    const Pixel full = seen_by(stills);
    const Pixel video = seen_in_part(stills, {1280, 720});
    EXPECT_NEAR(2.0 * video.u + 0.5, full.u, 1e-9);
    EXPECT_NEAR(2.0 * video.v + 0.5 + 240.0, full.v, 1e-9);
}

TEST(ImageSizeTest, AnEnlargedImageIsUnderstoodAndOneThatShowsMoreIsNot) {
    const Pixel full = seen_by(camera_of_size(640, 480));
    const Pixel twice = seen_in_part(camera_of_size(640, 480), {1280, 960});
    EXPECT_NEAR(twice.u, 2.0 * full.u + 0.5, 1e-9);
    EXPECT_FALSE(part_of(camera_of_size(640, 360), {640, 480}));
    EXPECT_FALSE(part_of(camera_of_size(640, 480), {1920, 1080}));
    EXPECT_FALSE(part_of(camera_of_size(640, 480), {0, 0}));
}

class ResizedDiveTest : public testing::Test {
protected:
    void calibrate_at_twice_the_size(const std::string& cam) const {
        const std::string file = "mav0/" + cam + "/sensor.yaml";
        tiny_.replace(file, "[64, 48]", "[128, 96]");
        tiny_.replace(file, "[50.0, 50.0, 32.0, 24.0]", "[100.0, 100.0, 64.5, 48.5]");
    }
    std::unique_ptr<Dive> open() const { return Dive::open(tiny_.folder(), folder_ / "scratch"); }

    const TemporaryFolder folder_;
    const TinyDive tiny_{folder_ / "dive"};
};

TEST_F(ResizedDiveTest, ACalibrationOfTwiceTheSizeIsAdaptedAndNamed) {
    calibrate_at_twice_the_size("cam0");
    calibrate_at_twice_the_size("cam1");
    const auto dive = open();
    EXPECT_THAT(dive->findings(),
                HasFinding(Severity::Warning, "calibration_resized", "0.500 times their size"));
    for (const types::Camera& camera : {dive->rig().cam0, dive->rig().cam1}) {
        EXPECT_EQ(camera.width_px, 64);
        EXPECT_EQ(camera.height_px, 48);
        EXPECT_NEAR(camera.fx_px, 50.0, 1e-9);
        EXPECT_NEAR(camera.cx_px, 32.0, 1e-9);
        EXPECT_NEAR(camera.cy_px, 24.0, 1e-9);
    }
}

TEST_F(ResizedDiveTest, OneOddImageChangesNothing) {
    tiny_.write("mav0/cam0/data/" + TinyDive::image_name(0), png_of_size(32, 24, 0));
    EXPECT_THAT(open()->findings(),
                testing::Not(HasFinding(Severity::Warning, "calibration_resized", "")));
}

}  // namespace
}  // namespace divemesh::dive
