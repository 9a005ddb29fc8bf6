#pragma once

#include <Eigen/Core>
#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>
#include <cmath>

#include "worker/board_calibration/rig_parameters.hpp"

namespace divemesh::board_calibration {

// Projects a point in front of a camera, m, as camera::project does, for automatic derivatives.
// Returns false for a point behind the camera.
template <typename T>
bool project_by_lens(types::Distortion distortion, const T* lens, const T* p_cam, T* pixel) {
    if (!(p_cam[2] > T(1e-6))) return false;
    const T x = p_cam[0] / p_cam[2];
    const T y = p_cam[1] / p_cam[2];
    const T r2 = x * x + y * y;
    const T* k = lens + 4;
    T dx = x;
    T dy = y;
    if (distortion == types::Distortion::RadialTangential) {
        const T radial = 1.0 + r2 * (k[0] + r2 * k[1]);
        dx = x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x);
        dy = y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y;
    } else if (distortion == types::Distortion::Equidistant && r2 > T(1e-16)) {
        using std::atan;
        using std::sqrt;
        const T r = sqrt(r2);
        const T theta = atan(r);
        const T t2 = theta * theta;
        const T factor = theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r;
        dx = x * factor;
        dy = y * factor;
    }
    pixel[0] = lens[0] * dx + lens[2];
    pixel[1] = lens[1] * dy + lens[3];
    return true;
}

// Returns T p for a pose of a rotation vector and a translation.
template <typename T>
void transform(const T* pose, const T* p, T* transformed) {
    ceres::AngleAxisRotatePoint(pose, p, transformed);
    for (int i = 0; i < 3; ++i) transformed[i] += pose[3 + i];
}

// The reprojection error of a corner of a board in the left camera, px:
//
//     r = lens0(T_cam0_board p_board) - pixel
//
// Blocks: lens0, T_cam0_board.
struct LeftBoardReprojection {
    types::Distortion distortion;
    Eigen::Vector3d p_board;
    Eigen::Vector2d pixel;

    template <typename T>
    bool operator()(const T* lens0, const T* T_cam0_board, T* r) const {
        const T p[3] = {T(p_board.x()), T(p_board.y()), T(p_board.z())};
        T p_cam0[3];
        transform(T_cam0_board, p, p_cam0);
        if (!project_by_lens(distortion, lens0, p_cam0, r)) return false;
        r[0] -= pixel.x();
        r[1] -= pixel.y();
        return true;
    }

    static ceres::CostFunction* create(const LeftBoardReprojection& reprojection) {
        return new ceres::AutoDiffCostFunction<LeftBoardReprojection, 2, kLensSize, kPoseSize>(
            new LeftBoardReprojection(reprojection));
    }
};

// The same in the right camera:
//
//     r = lens1(T_cam1_cam0 T_cam0_board p_board) - pixel
//
// Blocks: lens1, T_cam1_cam0, T_cam0_board.
struct RightBoardReprojection {
    types::Distortion distortion;
    Eigen::Vector3d p_board;
    Eigen::Vector2d pixel;

    template <typename T>
    bool operator()(const T* lens1, const T* T_cam1_cam0, const T* T_cam0_board, T* r) const {
        const T p[3] = {T(p_board.x()), T(p_board.y()), T(p_board.z())};
        T p_cam0[3];
        T p_cam1[3];
        transform(T_cam0_board, p, p_cam0);
        transform(T_cam1_cam0, p_cam0, p_cam1);
        if (!project_by_lens(distortion, lens1, p_cam1, r)) return false;
        r[0] -= pixel.x();
        r[1] -= pixel.y();
        return true;
    }

    static ceres::CostFunction* create(const RightBoardReprojection& reprojection) {
        return new ceres::
            AutoDiffCostFunction<RightBoardReprojection, 2, kLensSize, kPoseSize, kPoseSize>(
                new RightBoardReprojection(reprojection));
    }
};

}  // namespace divemesh::board_calibration
