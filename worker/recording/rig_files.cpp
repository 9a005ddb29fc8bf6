#include "worker/recording/rig_files.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "schemas/error.hpp"
#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/sensor_yaml_text.hpp"
#include "worker/recording/input_file.hpp"

namespace divemesh::recording {
namespace {

constexpr std::size_t kMaxCoefficients = 14;  // OpenCV's largest model
constexpr const char* kComment = "from CameraInfo";
// The pose is tf_static's, so that of the IMU is the body's own frame.
constexpr const char* kImuComment = "the pose is from tf_static, the noise is not known";
// What tf_static may differ from CameraInfo by.
constexpr double kMaxLengthDifference = 0.01;
constexpr double kMaxAngle_deg = 1.0;
constexpr const char* kRemedy = ": state the calibration by --calibration";

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

// Throws the first error of `findings`, if there is one, and passes the rest on.
void pass_on(const dive::FindingLog& findings, dive::FindingLog& all) {
    for (const Finding& finding : findings.all()) {
        if (finding.severity == Severity::Error)
            fail(finding.where + ": " + finding.message + ": " + finding.remedy);
        all.add(finding);
    }
}

dive::CalibratedCamera checked_camera(const std::string& text,
                                      const std::string& file,
                                      dive::FindingLog& all) {
    dive::FindingLog findings;
    const auto yaml = dive::parse_sensor_yaml(text, file, findings);
    const auto camera = yaml ? dive::calibrated_camera(*yaml, file, findings) : std::nullopt;
    pass_on(findings, all);
    return camera.value();  // without an error there is one
}

std::string text_of(const std::filesystem::path& file) {
    const InputFile input(file);
    return input.read(0, dive::kMaxYamlBytes);
}

Eigen::Matrix3d rectification_of(const CameraInfo& info) {
    const Eigen::Matrix3d R_rect_cam =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info.rectification.data());
    return R_rect_cam.isZero() ? Eigen::Matrix3d::Identity() : R_rect_cam;
}

// Returns by how much the projection moves the camera along x in the rectified frame, in m.
double shift_m(const CameraInfo& info) { return -info.projection[3] / info.projection[0]; }

Eigen::Isometry3d pose_of_right(const CameraInfo& left,
                                const CameraInfo& right,
                                Rectification rectification) {
    const Eigen::Vector3d baseline(shift_m(right) - shift_m(left), 0.0, 0.0);
    Eigen::Isometry3d T_cam0_cam1 = Eigen::Isometry3d::Identity();
    T_cam0_cam1.translation() = baseline;
    if (rectification == Rectification::Rectified) return T_cam0_cam1;
    const Eigen::Matrix3d R_cam0_rect = rectification_of(left).transpose();
    T_cam0_cam1.linear() = R_cam0_rect * rectification_of(right);
    T_cam0_cam1.translation() = R_cam0_rect * baseline;
    return T_cam0_cam1;
}

bool has_baseline(const CameraInfo& left, const CameraInfo& right) {
    return left.projection[0] != 0.0 && right.projection[0] != 0.0 &&
           shift_m(left) != shift_m(right);
}

// Returns a pose as people compare it.
std::string pose_text(const Eigen::Isometry3d& T_cam0_cam1) {
    const Eigen::Vector3d t = T_cam0_cam1.translation();
    std::string text = base::significant(t.norm()) + " m away, at (" + base::fixed(t.x(), 4);
    text += ", " + base::fixed(t.y(), 4);
    text += ", " + base::fixed(t.z(), 4);
    text += ") m, turned by ";
    text += base::fixed(base::angle_rad(T_cam0_cam1.linear()) * base::kDegPerRad, 2);
    return text + " degrees";
}

// Returns whether the pose of cam1 by tf_static differs from CameraInfo's, with a warning.
bool contradicts(const Eigen::Isometry3d& by_frames,
                 const Eigen::Isometry3d& by_info,
                 dive::FindingLog& findings) {
    const Eigen::Vector3d a = by_frames.translation();
    const Eigen::Vector3d b = by_info.translation();
    const double direction_rad = std::atan2(a.cross(b).norm(), a.dot(b));
    const double rotation_rad = base::angle_rad(by_frames.linear().transpose() * by_info.linear());
    if (std::abs(a.norm() - b.norm()) <= kMaxLengthDifference * b.norm() &&
        std::max(direction_rad, rotation_rad) * base::kDegPerRad <= kMaxAngle_deg)
        return false;
    findings.warning("transform_contradicts_camera_info",
                     "tf_static",
                     "the right camera is " + pose_text(by_info) +
                         " from the left one by CameraInfo, but " + pose_text(by_frames) +
                         " by tf_static; CameraInfo is used, tf_static is not",
                     "Correct the robot's description, or state the calibration by "
                     "--calibration.");
    return true;
}

// Returns T_cam0_cam1 of the images: of CameraInfo if it states it, else of the frames.
Eigen::Isometry3d chosen_pose(const CameraInfo& left,
                              const CameraInfo& right,
                              Rectification rectification,
                              const RigPoses& poses) {
    if (has_baseline(left, right)) return pose_of_right(left, right, rectification);
    if (!poses.T_cam0_cam1)
        fail(std::string("CameraInfo states no baseline in P of the right camera, and tf_static "
                         "does not relate the cameras") +
             kRemedy);
    if (rectification == Rectification::Raw) return *poses.T_cam0_cam1;
    return Eigen::Isometry3d(rectification_of(left)) * *poses.T_cam0_cam1 *
           Eigen::Isometry3d(rectification_of(right).transpose());
}

// Returns the name of a lens model that sensor.yaml knows; a rational model whose further
// coefficients are 0 is the radial-tangential one.
std::string distortion_of(const CameraInfo& info) {
    const auto& k = info.distortion_coefficients;
    const std::string& model = info.distortion_model;
    if (!is_model_name(model) || k.size() > kMaxCoefficients)
        fail(std::string("the lens model of CameraInfo is not one of ROS") + kRemedy);
    if (std::all_of(k.begin(), k.end(), [](double value) { return value == 0.0; })) return "none";
    return model == "rational_polynomial" ? "plumb_bob" : model;
}

dive::SensorYaml yaml_of(const CameraInfo& info,
                         const Eigen::Isometry3d& T_body_cam,
                         Rectification rectification) {
    dive::SensorYaml yaml;
    yaml.T_body_sensor = T_body_cam.matrix();
    yaml.camera_model = "pinhole";
    yaml.resolution = {static_cast<double>(info.width_px), static_cast<double>(info.height_px)};
    if (rectification == Rectification::Rectified) {
        const auto& p = info.projection;
        yaml.intrinsics = {p[0], p[5], p[2], p[6]};
        yaml.distortion_model = "none";
        return yaml;
    }
    const auto& k = info.camera_matrix;
    yaml.intrinsics = {k[0], k[4], k[2], k[5]};
    yaml.distortion_model = distortion_of(info);
    if (yaml.distortion_model != "none")
        yaml.distortion_coefficients = info.distortion_coefficients;
    return yaml;
}

}  // namespace

RigFiles uncalibrated_rig(ImageSize left, ImageSize right) {
    RigFiles rig;
    for (const auto& [camera, size] :
         {std::pair(&rig.cam0.camera, left), std::pair(&rig.cam1.camera, right)}) {
        camera->width_px = static_cast<int>(size.width_px);
        camera->height_px = static_cast<int>(size.height_px);
    }
    return rig;
}

bool is_model_name(const std::string& name) {
    return name.size() <= kMaxName_bytes && std::all_of(name.begin(), name.end(), [](char letter) {
               return (letter >= 'a' && letter <= 'z') || letter == '_' || letter == '-';
           });
}

void check_rig(RigFiles& rig, dive::FindingLog& all) {
    rig.cam0 = checked_camera(rig.cam0_yaml, "mav0/cam0/sensor.yaml", all);
    rig.cam1 = checked_camera(rig.cam1_yaml, "mav0/cam1/sensor.yaml", all);
    dive::FindingLog findings;
    dive::check_stereo(rig.cam0, rig.cam1, findings);
    pass_on(findings, all);
}

RigFiles rig_of_folder(const std::filesystem::path& folder, dive::FindingLog& findings) {
    const auto root = std::filesystem::exists(folder / "mav0") ? folder / "mav0" : folder;
    RigFiles rig;
    rig.cam0_yaml = text_of(root / "cam0" / "sensor.yaml");
    rig.cam1_yaml = text_of(root / "cam1" / "sensor.yaml");
    const auto imu_yaml = root / "imu0" / "sensor.yaml";
    if (std::filesystem::exists(imu_yaml)) rig.imu_yaml = text_of(imu_yaml);
    check_rig(rig, findings);
    return rig;
}

RigFiles rig_of_infos(const CameraInfo& left,
                      const CameraInfo& right,
                      Rectification rectification,
                      RigPoses poses,
                      dive::FindingLog& findings) {
    if (left.camera_matrix[0] == 0.0 || right.camera_matrix[0] == 0.0)
        fail(std::string("CameraInfo says that the cameras are not calibrated") + kRemedy);
    if (rectification == Rectification::Rectified &&
        (left.projection[0] == 0.0 || right.projection[0] == 0.0))
        fail(std::string("CameraInfo states no P of the rectified images") + kRemedy);
    if (poses.T_cam0_cam1 && has_baseline(left, right) &&
        contradicts(*poses.T_cam0_cam1, pose_of_right(left, right, Rectification::Raw), findings))
        poses = {};
    const Eigen::Isometry3d T_cam0_cam1 = chosen_pose(left, right, rectification, poses);
    Eigen::Isometry3d T_body_cam0 = poses.T_imu_cam0.value_or(Eigen::Isometry3d::Identity());
    if (poses.T_imu_cam0 && rectification == Rectification::Rectified)
        T_body_cam0 = T_body_cam0 * Eigen::Isometry3d(rectification_of(left).transpose());
    RigFiles rig;
    rig.cam0_yaml = dive::camera_yaml_text(yaml_of(left, T_body_cam0, rectification), {kComment});
    rig.cam1_yaml = dive::camera_yaml_text(yaml_of(right, T_body_cam0 * T_cam0_cam1, rectification),
                                           {kComment});
    if (poses.T_imu_cam0) rig.imu_yaml = dive::imu_yaml_text({}, {kImuComment});
    check_rig(rig, findings);
    return rig;
}

}  // namespace divemesh::recording
