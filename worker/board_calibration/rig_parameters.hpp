#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string_view>

#include "worker/types/camera.hpp"

namespace divemesh::board_calibration {

inline constexpr int kLensSize = 8;  // fx fy cx cy, px; then the four distortion coefficients
inline constexpr int kPoseSize = 6;  // rotation vector, rad; translation, m
inline constexpr int kRigSize = 2 * kLensSize + kPoseSize;

using LensValues = std::array<double, kLensSize>;
using PoseValues = std::array<double, kPoseSize>;
using RigVector = Eigen::Matrix<double, kRigSize, 1>;
using RigCovariance = Eigen::Matrix<double, kRigSize, kRigSize>;

// The names of the rig's parameters with their units, in the order of RigVector.
extern const std::array<std::string_view, kRigSize> kRigNames;

// The size of a camera's images and the lens model, which are not estimated.
struct LensKind {
    int width_px = 0;
    int height_px = 0;
    types::Distortion distortion = types::Distortion::RadialTangential;
};

types::Camera camera_of(const LensKind& kind, const LensValues& values);
Eigen::Isometry3d isometry_of(const PoseValues& values);
PoseValues values_of(const Eigen::Isometry3d& T);

// Holds what is estimated of a stereo rig.
struct RigParameters {
    LensKind kind0;
    LensKind kind1;
    LensValues lens0 = {};
    LensValues lens1 = {};
    PoseValues T_cam1_cam0 = {};

    types::Camera cam0() const { return camera_of(kind0, lens0); }
    types::Camera cam1() const { return camera_of(kind1, lens1); }
    RigVector vector() const;
    RigParameters changed_by(const RigVector& change) const;
};

}  // namespace divemesh::board_calibration
