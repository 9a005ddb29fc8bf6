#include "worker/recording/kalibr_calibration.hpp"

#include <cmath>

#include "schemas/error.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/yaml_document.hpp"

namespace divemesh::recording {
namespace {

constexpr std::size_t kMaxCameras = 16;
constexpr double kMaxShift_s = 1e6;
constexpr double kMaxBetween_s = 1e-3;  // shifts of cameras that are triggered together

std::string camera_name(std::size_t index) { return "cam" + std::to_string(index); }

YAML::Node camera_at(const YAML::Node& root, std::size_t index) { return root[camera_name(index)]; }

// Returns the number of cameras: cam0, cam1 ... without a gap.
std::size_t count_cameras(const YAML::Node& root) {
    std::size_t count = 0;
    while (count < kMaxCameras && camera_at(root, count)) ++count;
    return count;
}

std::optional<std::size_t> camera_of_topic(const YAML::Node& root,
                                           std::size_t num_cameras,
                                           const std::string& topic) {
    for (std::size_t i = 0; i < num_cameras && !topic.empty(); ++i) {
        const std::string stated = dive::text_at(camera_at(root, i), "rostopic");
        if (stated == topic || stated + "/compressed" == topic) return i;
    }
    return std::nullopt;
}

// Returns the camera's pose on the IMU: the inverse of T_cam_imu, or T_imu_cam as OpenVINS has it.
std::optional<Eigen::Matrix4d> pose_on_imu(const YAML::Node& camera, const std::string& name) {
    if (const auto T_cam_imu = dive::matrix_at(camera, "T_cam_imu"))
        return rigid_transform(*T_cam_imu, "T_cam_imu of " + name).inverse().matrix();
    const auto T_imu_cam = dive::matrix_at(camera, "T_imu_cam");
    if (!T_imu_cam) return std::nullopt;
    return rigid_transform(*T_imu_cam, "T_imu_cam of " + name).matrix();
}

dive::SensorYaml read_camera(const YAML::Node& camera, const std::string& name) {
    dive::SensorYaml yaml;
    yaml.T_body_sensor = pose_on_imu(camera, name);
    yaml.camera_model = dive::text_at(camera, "camera_model");
    yaml.intrinsics = dive::numbers_at(camera, "intrinsics");
    yaml.distortion_model = dive::text_at(camera, "distortion_model");
    yaml.distortion_coefficients = dive::numbers_at(camera, "distortion_coeffs");
    yaml.resolution = dive::numbers_at(camera, "resolution");
    return yaml;
}

// Returns the transform from one camera to a later one of the chain; nullopt where a link of the
// chain is missing.
std::optional<Eigen::Matrix4d> along_chain(const YAML::Node& root,
                                           std::size_t from,
                                           std::size_t to,
                                           const std::string& file) {
    Eigen::Isometry3d T_camn_from = Eigen::Isometry3d::Identity();
    for (std::size_t i = from + 1; i <= to; ++i) {
        const auto T_cn_cnm1 = dive::matrix_at(camera_at(root, i), "T_cn_cnm1");
        if (!T_cn_cnm1) return std::nullopt;
        const std::string name = "T_cn_cnm1 of " + camera_name(i) + " in " + file;
        T_camn_from = rigid_transform(*T_cn_cnm1, name) * T_camn_from;
    }
    return T_camn_from.matrix();
}

std::optional<Eigen::Matrix4d> T_right_left(const YAML::Node& root,
                                            std::size_t left,
                                            std::size_t right,
                                            const std::string& file) {
    if (left < right) return along_chain(root, left, right, file);
    const auto T_left_right = along_chain(root, right, left, file);
    if (!T_left_right) return std::nullopt;
    return rigid_transform(*T_left_right, "the chain of " + file).inverse().matrix();
}

double shift_of(const YAML::Node& camera, const std::string& file) {
    const double shift_s = dive::number_at(camera, "timeshift_cam_imu").value_or(0.0);
    if (!(std::abs(shift_s) <= kMaxShift_s))
        throw Error(ErrorCode::BadData,
                    file + " states a timeshift_cam_imu of " + base::significant(shift_s) +
                        " s, which no clock is off by: check the file");
    return shift_s;
}

// Returns how the clocks of the left camera and the IMU differ; nullopt if they do not.
std::optional<ImuShift> imu_shift(const YAML::Node& left,
                                  const YAML::Node& right,
                                  const std::string& file,
                                  dive::FindingLog& findings) {
    const double left_s = shift_of(left, file);
    const double right_s = shift_of(right, file);
    if (right["timeshift_cam_imu"] && std::abs(left_s - right_s) > kMaxBetween_s)
        findings.info("calibration_time_offsets_differ",
                      file,
                      "timeshift_cam_imu is " + base::significant(left_s * 1e3) +
                          " ms of the left camera and " + base::significant(right_s * 1e3) +
                          " ms of the right one, so they were not triggered together; that of the "
                          "left one counts");
    if (left_s == 0.0) return std::nullopt;
    return ImuShift{left_s, file};
}

}  // namespace

CalibrationParts read_kalibr_chain(const YAML::Node& root,
                                   const std::string& file,
                                   const RigHints& hints,
                                   dive::FindingLog& findings) {
    const std::size_t num_cameras = count_cameras(root);
    if (num_cameras < 2)
        throw Error(ErrorCode::BadData,
                    file + " states " + std::to_string(num_cameras) +
                        " cameras: calibrate both cameras of the pair in one chain");
    const auto by_topic_left = camera_of_topic(root, num_cameras, hints.left_topic);
    const auto by_topic_right = camera_of_topic(root, num_cameras, hints.right_topic);
    const bool by_topic = by_topic_left && by_topic_right && *by_topic_left != *by_topic_right;
    const std::size_t left = by_topic ? *by_topic_left : 0;
    const std::size_t right = by_topic ? *by_topic_right : 1;
    if (num_cameras > 2 || left > right)
        findings.info("calibration_sides",
                      file,
                      camera_name(left) + " of " + std::to_string(num_cameras) +
                          " cameras is used as the left one, " + camera_name(right) +
                          " as the right one");
    CalibrationParts parts;
    parts.left = read_camera(camera_at(root, left), camera_name(left) + " in " + file);
    parts.right = read_camera(camera_at(root, right), camera_name(right) + " in " + file);
    parts.T_cam1_cam0 = T_right_left(root, left, right, file);
    parts.imu_shift = imu_shift(camera_at(root, left), camera_at(root, right), file, findings);
    return parts;
}

std::optional<dive::SensorYaml> read_kalibr_imu(const YAML::Node& root) {
    const YAML::Node imu = root["imu0"] ? root["imu0"] : root;
    if (!imu.IsMap() || !imu["gyroscope_noise_density"]) return std::nullopt;
    dive::SensorYaml yaml;
    yaml.gyroscope_noise_density = dive::number_at(imu, "gyroscope_noise_density");
    yaml.gyroscope_random_walk = dive::number_at(imu, "gyroscope_random_walk");
    yaml.accelerometer_noise_density = dive::number_at(imu, "accelerometer_noise_density");
    yaml.accelerometer_random_walk = dive::number_at(imu, "accelerometer_random_walk");
    return yaml;
}

}  // namespace divemesh::recording
