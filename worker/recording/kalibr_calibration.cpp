#include "worker/recording/kalibr_calibration.hpp"

#include <cmath>

#include "schemas/error.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/yaml_document.hpp"

namespace divemesh::recording {
namespace {

constexpr std::size_t kMaxCameras = 16;
// The range in which reconstruction searches the time offset of the IMU.
constexpr double kSearched_s = 0.07;

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

void report_time_offset(const YAML::Node& camera,
                        const std::string& file,
                        dive::FindingLog& findings) {
    const auto shift_s = dive::number_at(camera, "timeshift_cam_imu");
    if (!shift_s || *shift_s == 0.0) return;
    const std::string stated =
        "the calibration states timeshift_cam_imu = " + base::significant(*shift_s * 1e3) +
        " ms; it is not applied";
    if (std::abs(*shift_s) <= kSearched_s)
        return findings.info("calibration_time_offset",
                             file,
                             stated + ": reconstruction finds it from the dive itself");
    findings.warning("calibration_time_offset",
                     file,
                     stated + " and too large to be found from the dive itself",
                     "Add it to the camera's timestamps (t_imu = t_cam + timeshift_cam_imu).");
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
    report_time_offset(camera_at(root, left), file, findings);
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
