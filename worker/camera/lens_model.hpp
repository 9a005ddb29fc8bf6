#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <numbers>
#include <span>
#include <string_view>

#include "worker/types/camera.hpp"

namespace divemesh::camera {

// Rays of a fisheye lens end at this angle to its axis: no rectified image shows what is beyond it
// (Rectifier ends its images earlier).
constexpr double kMaxFisheyeAngle_rad = 85.0 * std::numbers::pi / 180.0;

// A coefficient that sensor.yaml states among the intrinsics, and the values it may have.
struct LeadingCoefficient {
    std::string_view name;
    double min = 0.0;
    double max = 0.0;
};

// What one lens model does. Normalised image coordinates are x / z and y / z of a ray before the
// lens; behind it they are pixels from the principal point over fx_px and fy_px.
struct LensModel {
    types::Distortion distortion;
    std::string_view name;          // in metrics.json and --camera-model
    std::string_view camera_model;  // in sensor.yaml, as Kalibr names it
    // In sensor.yaml: the first is written, all are read.
    std::span<const std::string_view> distortion_models;
    std::size_t num_coefficients;
    // The first of the coefficients; sensor.yaml states them before the focal lengths.
    std::span<const LeadingCoefficient> leading;
    // Coefficients at which an estimate starts; a later one counts where it ends clearly better.
    std::span<const types::LensCoefficients> starts;
    bool is_fisheye;  // may see beyond 85 degrees: rays end at kMaxFisheyeAngle_rad
    // Returns the focal length of sensor.yaml over fx_px, which is that on the axis.
    double (*focal_factor)(const types::LensCoefficients& k);
    // Returns normalised image coordinates behind the lens for those before it.
    Eigen::Vector2d (*distort)(const types::LensCoefficients& k, const Eigen::Vector2d& n);
    // Returns the inverse of distort.
    Eigen::Vector2d (*undistort)(const types::LensCoefficients& k, const Eigen::Vector2d& d);
};

// Returns all models, in the order of types::Distortion.
std::span<const LensModel> lens_models();
const LensModel& lens_model(types::Distortion distortion);

}  // namespace divemesh::camera
