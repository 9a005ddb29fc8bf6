#pragma once

#include <array>

#include "worker/calibration/lens_reprojection.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/rig_alignment.hpp"

namespace divemesh::calibration {

using LensChanges = Eigen::Matrix<double, LensReprojection::kNumChanges, 1>;  // left, right
using LensCovariance =
    Eigen::Matrix<double, LensReprojection::kNumChanges, LensReprojection::kNumChanges>;

// Standard deviations of the errors of a careful calibration under water.
constexpr double kBaselineSigma = 0.002;       // relative
constexpr double kStereoRotationSigma = 5e-4;  // rad, of the right camera about each axis
// The same after the rows of the images were aligned; the yaw is then part of the lenses' centres.
constexpr double kAlignedRotationSigma = 1.5e-4;  // rad
constexpr double kImuRotationSigma_rad = 4.4e-3;
constexpr double kLeverArmSigma_m = 2e-3;  // of the cameras on the IMU, along each axis
constexpr double kTimeOffsetSigma_s = 4e-3;
constexpr double kRateErrorSigma = 0.02;  // of a gyroscope that nobody calibrated, relative

// Returns the changes of the left and of the right lens as one vector.
LensChanges joined(const std::array<types::LensChange, 2>& lenses);

// Returns the standard deviations of the lenses' calibration. That of the right principal point
// includes the yaw of the right camera, as both move all disparities alike. Where an image is
// shifted on its sensor, those of the principal points include the shift: rows tell the difference
// of both cameras, not which of them it is.
LensChanges lens_prior_sigmas(const types::Rig& rig, const types::RigAlignment& alignment);

}  // namespace divemesh::calibration
