#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "worker/types/camera.hpp"

namespace divemesh::board_calibration {

inline constexpr int kPinholeSize = 4;   // fx fy cx cy, px
inline constexpr int kMaxLensSize = 12;  // and then the coefficients of the lens model
inline constexpr int kPoseSize = 6;      // rotation vector, rad; translation, m

using LensValues = std::array<double, kMaxLensSize>;  // those that a model has not are 0
using PoseValues = std::array<double, kPoseSize>;
// Both lenses, each with as many values as its model has, and the relative pose.
using RigVector = Eigen::VectorXd;
using RigCovariance = Eigen::MatrixXd;

// The size of a camera's images and the lens model, which are not estimated.
struct LensKind {
    int width_px = 0;
    int height_px = 0;
    types::Distortion distortion = types::Distortion::RadialTangential;

    int num_values() const;  // of a lens
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
    int size() const { return kind0.num_values() + kind1.num_values() + kPoseSize; }
    RigVector vector() const;
    // Returns the names of the parameters with their units, in the order of vector().
    std::vector<std::string> names() const;
    RigParameters changed_by(const RigVector& change) const;
};

}  // namespace divemesh::board_calibration
