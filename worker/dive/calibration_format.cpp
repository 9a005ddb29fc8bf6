#include "worker/dive/calibration_format.hpp"

namespace divemesh::dive {
namespace {

bool has(std::string_view text, std::string_view key) {
    return text.find(key) != std::string_view::npos;
}

}  // namespace

std::optional<CalibrationFormat> foreign_calibration(std::string_view text) {
    if (has(text, "T_BS")) return std::nullopt;
    if (has(text, "T_cam_imu") || has(text, "T_cn_cnm1") || has(text, "distortion_coeffs"))
        return CalibrationFormat{
            "a camera chain of Kalibr",
            "For each camera write mav0/camN/sensor.yaml with T_BS = the inverse of T_cam_imu (4 "
            "x 4), camera_model, intrinsics and resolution as they are, distortion_model and "
            "distortion_coeffs as distortion_coefficients. Without an IMU T_BS of cam0 is the "
            "identity and that of cam1 the inverse of T_cn_cnm1."};
    if (has(text, "camera_matrix") && has(text, "image_width"))
        return CalibrationFormat{
            "camera_info of ROS",
            "Write resolution: [image_width, image_height], intrinsics: [fx, fy, cx, cy] of "
            "camera_matrix, the first four distortion_coefficients, camera_model: pinhole, "
            "distortion_model: radial-tangential, and T_BS: the identity for cam0, for cam1 x = "
            "-P[3] / P[0] of its projection_matrix and the rotation between both "
            "rectification_matrix."};
    if (has(text, "opencv-matrix"))
        return CalibrationFormat{
            "a file of OpenCV's calibration",
            "Write intrinsics: [fx, fy, cx, cy] of M1 or K, the first four numbers of D1 as "
            "distortion_coefficients, resolution, camera_model: pinhole, distortion_model: "
            "radial-tangential, and T_BS: the identity for cam0, for cam1 the inverse of [R T] of "
            "stereoCalibrate, in m."};
    return std::nullopt;
}

}  // namespace divemesh::dive
