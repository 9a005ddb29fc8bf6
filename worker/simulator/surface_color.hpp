#pragma once

#include <Eigen/Core>

#include "worker/simulator/noise_field.hpp"
#include "worker/simulator/scene.hpp"

namespace divemesh::simulator {

using Rgb = Eigen::Array3f;  // linear, 0 to 1

// Returns the noise behind all textures of a place.
NoiseField texture_noise(std::uint64_t seed);

// Returns the reflectance of an object at a point of the world, as seen by a pixel that covers
// `footprint_m` there. Patterns range from a metre down to millimetres; what a pixel cannot resolve
// is faded out to avoid aliasing.
Rgb surface_color(const SceneObject& object,
                  const NoiseField& noise,
                  const Eigen::Vector3f& p_world,
                  const Eigen::Vector3f& normal_world,
                  float footprint_m);

}  // namespace divemesh::simulator
