#include "worker/recording/assemble_rig.hpp"

#include <array>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/sensor_yaml_text.hpp"

namespace divemesh::recording {
namespace {

constexpr const char* kComment = "calibration imported by divemesh";
// How much two statements of the same pose may differ: files keep at least four decimals.
constexpr double kMaxContradiction_m = 1e-3;
constexpr double kMaxContradiction_rad = 2e-3;

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

dive::SensorYaml camera_of(const std::optional<dive::SensorYaml>& sided,
                           const CalibrationParts& parts,
                           std::size_t index,
                           const RigHints& hints) {
    if (sided && !parts.unsided.empty())
        fail("two calibrations state the cameras: give one of them alone");
    if (!sided && parts.unsided.size() != 2)
        fail("the calibration states " + std::to_string(parts.unsided.size()) +
             " cameras, not two: give the files of the left and of the right camera, in this "
             "order");
    dive::SensorYaml camera = sided ? *sided : parts.unsided[index];
    if (camera.resolution.empty()) camera.resolution = hints.resolution;
    if (camera.resolution.empty())
        fail(
            "the calibration does not state the size of the images: state it by --image-size, for "
            "example 1920x1080");
    return camera;
}

void check_agreement(const Eigen::Isometry3d& T_cam1_cam0, const Eigen::Isometry3d& stated) {
    const Eigen::Isometry3d difference = T_cam1_cam0.inverse() * stated;
    const double angle_rad = base::angle_rad(difference.linear());
    if (difference.translation().norm() < kMaxContradiction_m && angle_rad < kMaxContradiction_rad)
        return;
    fail(
        "the calibration contradicts itself: by the poses of both cameras on the IMU the right "
        "camera is " +
        base::fixed(difference.translation().norm(), 3) + " m and " +
        base::fixed(angle_rad * base::kDegPerRad, 2) +
        " degrees from where the transform between the cameras puts it: remove T_cn_cnm1 or "
        "T_cam_imu, whichever is outdated");
}

// States both poses of cameras on the body, which is the left camera where no IMU is known.
void place(dive::SensorYaml& left,
           dive::SensorYaml& right,
           const std::optional<Eigen::Matrix4d>& between) {
    std::optional<Eigen::Isometry3d> T_cam1_cam0;
    if (between)
        T_cam1_cam0 = rigid_transform(*between, "the transform from the left to the right camera");
    if (left.T_body_sensor && right.T_body_sensor) {
        if (!T_cam1_cam0) return;
        const auto T_imu_cam0 = rigid_transform(*left.T_body_sensor, "the pose of the left camera");
        const auto T_imu_cam1 =
            rigid_transform(*right.T_body_sensor, "the pose of the right camera");
        return check_agreement(T_imu_cam1.inverse() * T_imu_cam0, *T_cam1_cam0);
    }
    if (!T_cam1_cam0)
        fail(
            "the calibration does not state where the cameras are relative to each other: add the "
            "file that does, such as extrinsics.yml of OpenCV with R and T");
    Eigen::Isometry3d T_body_cam0 = Eigen::Isometry3d::Identity();
    if (left.T_body_sensor)
        T_body_cam0 = rigid_transform(*left.T_body_sensor, "the pose of the left camera");
    if (right.T_body_sensor)
        T_body_cam0 =
            rigid_transform(*right.T_body_sensor, "the pose of the right camera") * *T_cam1_cam0;
    left.T_body_sensor = T_body_cam0.matrix();
    right.T_body_sensor = (T_body_cam0 * T_cam1_cam0->inverse()).matrix();
}

void check_names(const dive::SensorYaml& camera) {
    for (const std::string& name : {camera.camera_model, camera.distortion_model})
        if (!is_model_name(name))
            fail(
                "the calibration names a camera model that is not known: calibrate with the "
                "pinhole model and radial-tangential or equidistant distortion, or with Kalibr's "
                "omni, ds or eucm");
}

// Returns the two infos with the left one first: that of the camera with the larger P[3] / P[0].
std::array<CameraInfo, 2> in_order(const std::vector<CameraInfo>& infos,
                                   dive::FindingLog& findings) {
    const auto shift = [](const CameraInfo& info) {
        return info.projection[0] == 0.0 ? 0.0 : info.projection[3] / info.projection[0];
    };
    if (shift(infos[0]) >= shift(infos[1])) return {infos[0], infos[1]};
    findings.info("calibration_sides",
                  infos[0].frame,
                  "the second camera_info is that of the left camera, by its projection matrix");
    return {infos[1], infos[0]};
}

RigFiles rig_of_ros(const CalibrationParts& parts,
                    const RigHints& hints,
                    dive::FindingLog& findings) {
    if (parts.infos.size() != 2 || parts.left || parts.right || !parts.unsided.empty())
        fail(
            "camera_info of ROS is read of both cameras of a pair, and without another "
            "calibration: give the two files");
    const auto [left, right] = in_order(parts.infos, findings);
    return rig_of_infos(left, right, hints.rectification, {}, findings);
}

std::string imu_text(const CalibrationParts& parts, dive::FindingLog& findings) {
    const dive::SensorYaml imu = parts.imu.value_or(dive::SensorYaml{});
    dive::imu_noise(imu, "the calibration of the IMU", findings);
    return dive::imu_yaml_text(imu, {kComment});
}

}  // namespace

RigFiles assemble_rig(const CalibrationParts& parts,
                      const RigHints& hints,
                      dive::FindingLog& findings) {
    if (!parts.infos.empty()) return rig_of_ros(parts, hints, findings);
    dive::SensorYaml left = camera_of(parts.left, parts, 0, hints);
    dive::SensorYaml right = camera_of(parts.right, parts, 1, hints);
    const bool is_imu_known = left.T_body_sensor || right.T_body_sensor;
    check_names(left);
    check_names(right);
    place(left, right, parts.T_cam1_cam0);
    RigFiles rig;
    rig.imu_shift = parts.imu_shift;
    rig.cam0_yaml = dive::camera_yaml_text(left, {kComment});
    rig.cam1_yaml = dive::camera_yaml_text(right, {kComment});
    if (is_imu_known)
        rig.imu_yaml = imu_text(parts, findings);
    else if (parts.imu)
        findings.warning("calibration_imu_unused",
                         "",
                         "the noise of the IMU is not used: the calibration does not state where "
                         "the IMU is relative to the cameras",
                         "Give a calibration with T_cam_imu, such as camchain-imucam.yaml.");
    check_rig(rig, findings);
    return rig;
}

}  // namespace divemesh::recording
