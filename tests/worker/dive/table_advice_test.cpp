#include "worker/dive/table_advice.hpp"

#include <gtest/gtest.h>

#include "worker/dive/calibration_format.hpp"

namespace divemesh::dive {
namespace {

TEST(TableAdviceTest, ATableAsItShouldBeGetsNoAdvice) {
    EXPECT_EQ(advise_on_table("#timestamp,filename\n1600000000000000000,a.png\n", 1).seen, "");
    EXPECT_EQ(advise_on_table("1600000000000000000,0.1,0.2\n", 2).seen, "");
    EXPECT_EQ(advise_on_table("", 2).seen, "");
}

TEST(TableAdviceTest, FormatsOfOtherToolsAreNamed) {
    const auto seen = [](const char* text) { return advise_on_table(text, 2).seen; };
    EXPECT_NE(seen("#t;x;y\n1600000000000000000;0,1;0,2\n").find("semicolons"), std::string::npos);
    EXPECT_NE(seen("1600000000.5 0.1 0.2\n").find("blanks"), std::string::npos);
    EXPECT_NE(seen("1600000000.5,0.1,0.2\n").find("seconds"), std::string::npos);
    EXPECT_NE(seen("1.60000E+18,0.1,0.2\n").find("exponential"), std::string::npos);
    EXPECT_NE(seen("\xff\xfe"
                   "1,2\n")
                  .find("UTF-16"),
              std::string::npos);
    EXPECT_NE(seen(",t,x,y\n0,1600000000000000000,1,2\n").find("counts the rows"),
              std::string::npos);
    EXPECT_NE(seen("1600000000000000000,1\n").find("2 of 3 columns"), std::string::npos);
}

TEST(CalibrationFormatTest, CalibrationsOfOtherToolsAreNamed) {
    const auto name = [](const char* text) {
        const auto foreign = foreign_calibration(text);
        return foreign ? foreign->name : "";
    };
    EXPECT_EQ(name("cam0:\n  T_cam_imu:\n  distortion_coeffs: [0, 0, 0, 0]\n"),
              "a camera chain of Kalibr");
    EXPECT_EQ(name("image_width: 640\ncamera_matrix:\n  rows: 3\n"), "camera_info of ROS");
    EXPECT_EQ(name("%YAML:1.0\nM1: !!opencv-matrix\n"), "a file of OpenCV's calibration");
    EXPECT_EQ(name("%YAML:1.0\nimage_width: 640\ncamera_matrix: !!opencv-matrix\n"),
              "a file of OpenCV's calibration");
    EXPECT_EQ(name("{\"fx_left\": 1, \"fx_right\": 1}"), "a stereo calibration of KWIVER");
    EXPECT_EQ(name("#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"),
              "a list of cameras of COLMAP");
    EXPECT_EQ(name("%YAML:1.0\nT_BS: !!opencv-matrix\n"), "");
    EXPECT_EQ(name("camera_model: pinhole\n"), "");
}

}  // namespace
}  // namespace divemesh::dive
