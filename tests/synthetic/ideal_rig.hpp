#pragma once

#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::synthetic {

// Returns an ideal stereo pair with a baseline of 12 cm and the principal point at the image
// centre.
inline types::RectifiedRig ideal_rig(int width_px, int height_px, double focal_px) {
    types::RectifiedRig rig;
    rig.width_px = width_px;
    rig.height_px = height_px;
    rig.focal_px = focal_px;
    rig.cx_px = 0.5 * (width_px - 1);
    rig.cy_px = 0.5 * (height_px - 1);
    rig.baseline_m = 0.12;
    return rig;
}

// Returns the calibration, without distortion, that rectifies to `rig`.
inline types::Rig ideal_cameras(const types::RectifiedRig& rig) {
    types::Rig result;
    result.cam0 = {.width_px = rig.width_px,
                   .height_px = rig.height_px,
                   .fx_px = rig.focal_px,
                   .fy_px = rig.focal_px,
                   .cx_px = rig.cx_px,
                   .cy_px = rig.cy_px,
                   .distortion = types::Distortion::None,
                   .distortion_coefficients = {}};
    result.cam1 = result.cam0;
    result.T_imu_cam0 = result.T_imu_cam1 = rig.T_imu_cam;
    result.T_imu_cam1.translate(rig.baseline_m * Eigen::Vector3d::UnitX());
    return result;
}

}  // namespace divemesh::synthetic
