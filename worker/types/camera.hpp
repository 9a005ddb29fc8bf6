#pragma once

#include <array>
#include <optional>

#include "worker/types/port.hpp"

namespace divemesh::types {

// The lens models; worker/camera/lens_model.hpp tells what each of them does:
// None               pinhole
// RadialTangential   k1 k2 p1 p2 (Brown 1966)
// Equidistant        k1 k2 k3 k4 (Kannala and Brandt 2006)
// Rational           k1 k2 p1 p2 k3 k4 k5 k6 (OpenCV); with k3 alone the radial-tangential one of
//                    five coefficients
// Omnidirectional    xi k1 k2 p1 p2 (Mei and Rives 2007)
// DoubleSphere       xi alpha (Usenko, Demmel and Cremers 2018)
// ExtendedUnified    alpha beta (Khomutenko, Garcia and Martinet 2016)
enum class Distortion {
    None,
    RadialTangential,
    Equidistant,
    Rational,
    Omnidirectional,
    DoubleSphere,
    ExtendedUnified
};

using LensCoefficients = std::array<double, 8>;  // those that a model has not are 0

// The calibration of one camera, pixel centres at integers (OpenCV). fx_px and fy_px are pixels per
// radian on the axis, whatever the model: a reader converts them. Behind a port they are those in
// air, and the camera's origin is where its rays in the water nearly meet.
struct Camera {
    int width_px = 0;
    int height_px = 0;
    double fx_px = 0.0;
    double fy_px = 0.0;
    double cx_px = 0.0;
    double cy_px = 0.0;
    Distortion distortion = Distortion::RadialTangential;
    LensCoefficients distortion_coefficients = {};
    // Refractive index of the medium in which the camera records over that in which it was
    // calibrated. Not 1: rays are refracted at a flat port before they reach the lens.
    double refractive_index = 1.0;
    std::optional<Port> port = std::nullopt;  // nullopt: none is described
};

}  // namespace divemesh::types
