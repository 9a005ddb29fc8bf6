#include "worker/dive/calibration_format.hpp"

namespace divemesh::dive {
namespace {

bool has(std::string_view text, std::string_view key) {
    return text.find(key) != std::string_view::npos;
}

// Returns how to make sensor.yaml files of such a calibration.
std::string by_import(const std::string& files) {
    return "divemesh import --calibration " + files +
           " --out DIVE writes sensor.yaml files of it; move a sensor.yaml that is there away "
           "first "
           "(docs/importing.md).";
}

}  // namespace

std::optional<CalibrationFormat> foreign_calibration(std::string_view text) {
    using enum CalibrationProgram;
    if (has(text, "T_BS")) return std::nullopt;
    if (has(text, "T_cam_imu") || has(text, "T_cn_cnm1") || has(text, "distortion_coeffs"))
        return CalibrationFormat{
            Kalibr, "a camera chain of Kalibr", by_import("camchain-imucam.yaml imu.yaml")};
    if (has(text, "fx_left") && has(text, "fx_right"))
        return CalibrationFormat{
            Kwiver, "a stereo calibration of KWIVER", by_import("calibration.json")};
    const bool is_ros = has(text, "projection_matrix") || !has(text, "opencv-matrix");
    if (is_ros && has(text, "camera_matrix") && has(text, "image_width"))
        return CalibrationFormat{Ros, "camera_info of ROS", by_import("left.yaml right.yaml")};
    if (has(text, "opencv-matrix"))
        return CalibrationFormat{
            OpenCv, "a file of OpenCV's calibration", by_import("intrinsics.yml extrinsics.yml")};
    if (has(text, "CAMERA_ID, MODEL, WIDTH, HEIGHT"))
        return CalibrationFormat{
            Colmap, "a list of cameras of COLMAP", by_import("cameras.txt extrinsics.yml")};
    return std::nullopt;
}

}  // namespace divemesh::dive
