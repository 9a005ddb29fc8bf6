#include "worker/board_calibration/rig_parameters.hpp"

#include <algorithm>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::board_calibration {

// clang-format off
const std::array<std::string_view, kRigSize> kRigNames = {
    "cam0_fx_px", "cam0_fy_px", "cam0_cx_px", "cam0_cy_px",
    "cam0_distortion_0", "cam0_distortion_1", "cam0_distortion_2", "cam0_distortion_3",
    "cam1_fx_px", "cam1_fy_px", "cam1_cx_px", "cam1_cy_px",
    "cam1_distortion_0", "cam1_distortion_1", "cam1_distortion_2", "cam1_distortion_3",
    "T_cam1_cam0_rotation_x_rad", "T_cam1_cam0_rotation_y_rad", "T_cam1_cam0_rotation_z_rad",
    "T_cam1_cam0_x_m", "T_cam1_cam0_y_m", "T_cam1_cam0_z_m"};
// clang-format on

types::Camera camera_of(const LensKind& kind, const LensValues& values) {
    types::Camera camera;
    camera.width_px = kind.width_px;
    camera.height_px = kind.height_px;
    camera.distortion = kind.distortion;
    camera.fx_px = values[0];
    camera.fy_px = values[1];
    camera.cx_px = values[2];
    camera.cy_px = values[3];
    std::copy(values.begin() + 4, values.end(), camera.distortion_coefficients.begin());
    return camera;
}

Eigen::Isometry3d isometry_of(const PoseValues& values) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = base::rotation_from_vector({values[0], values[1], values[2]}).toRotationMatrix();
    T.translation() = Eigen::Vector3d(values[3], values[4], values[5]);
    return T;
}

PoseValues values_of(const Eigen::Isometry3d& T) {
    const Eigen::Vector3d w = base::vector_from_rotation(Eigen::Quaterniond(T.linear()));
    const Eigen::Vector3d t = T.translation();
    return {w.x(), w.y(), w.z(), t.x(), t.y(), t.z()};
}

RigVector RigParameters::vector() const {
    RigVector all;
    std::copy(lens0.begin(), lens0.end(), all.begin());
    std::copy(lens1.begin(), lens1.end(), all.begin() + kLensSize);
    std::copy(T_cam1_cam0.begin(), T_cam1_cam0.end(), all.begin() + 2 * kLensSize);
    return all;
}

RigParameters RigParameters::changed_by(const RigVector& change) const {
    const RigVector all = vector() + change;
    RigParameters changed = *this;
    std::copy_n(all.begin(), kLensSize, changed.lens0.begin());
    std::copy_n(all.begin() + kLensSize, kLensSize, changed.lens1.begin());
    std::copy_n(all.begin() + 2 * kLensSize, kPoseSize, changed.T_cam1_cam0.begin());
    return changed;
}

}  // namespace divemesh::board_calibration
