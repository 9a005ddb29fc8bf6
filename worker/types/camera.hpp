#pragma once

#include <array>

namespace divemesh::types {

// The lens models: radial-tangential (Brown 1966) and equidistant (Kannala and Brandt 2006). A
// projection of its own kind is one more value here.
enum class Distortion { None, RadialTangential, Equidistant };

inline constexpr std::array kDistortions = {
    Distortion::None, Distortion::RadialTangential, Distortion::Equidistant};

// The calibration of one camera: pinhole with lens distortion, pixel centres at integers (OpenCV).
// fx_px and fy_px are pixels per radian on the axis, whatever the model: a reader converts them.
// Distortion coefficients: k1 k2 p1 p2 (radial-tangential) or k1 k2 k3 k4 (equidistant).
struct Camera {
    int width_px = 0;
    int height_px = 0;
    double fx_px = 0.0;
    double fy_px = 0.0;
    double cx_px = 0.0;
    double cy_px = 0.0;
    Distortion distortion = Distortion::RadialTangential;
    std::array<double, 4> distortion_coefficients = {0.0, 0.0, 0.0, 0.0};
    // Refractive index of the medium in which the camera records over that in which it was
    // calibrated. Not 1: rays are refracted at a flat port before they reach the lens.
    double refractive_index = 1.0;
};

}  // namespace divemesh::types
