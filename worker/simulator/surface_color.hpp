#pragma once

#include <Eigen/Core>

#include "worker/simulator/noise_field.hpp"
#include "worker/simulator/scene.hpp"

namespace divemesh::simulator {

using Rgb = Eigen::Array3f;  // linear, 0 to 1

// The noise behind all textures of a place.
NoiseField texture_noise(std::uint64_t seed);

// The reflectance of an object at a point of the world, as seen by a pixel that covers
// `footprint_m` there. Patterns from a metre down to millimetres: what a pixel cannot resolve is
// faded out, so that nothing aliases.
Rgb surface_color(const SceneObject& object,
                  const NoiseField& noise,
                  const Eigen::Vector3f& p_world,
                  const Eigen::Vector3f& normal_world,
                  float footprint_m);

}  // namespace divemesh::simulator
