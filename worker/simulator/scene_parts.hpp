#pragma once

#include <string>

#include "worker/base/hashed_random.hpp"
#include "worker/simulator/scene.hpp"

// Objects that several scenes share. The number of the part is appended to names.
namespace divemesh::simulator {

// Adds an exact box that stands on z = 0 of `T_place_box`, and its length, width and height as
// known distances.
void add_measured_box(SceneBuilder& builder,
                      const std::string& name,
                      Material material,
                      const Eigen::Vector3f& size_m,
                      const Eigen::Isometry3f& T_place_box);
// Adds a bar in black and white segments of 0.1 m along x with its underside at z = 0, and its
// length as a known distance.
void add_scale_bar(SceneBuilder& builder,
                   const std::string& name,
                   float length_m,
                   const Eigen::Isometry3f& T_place_bar);
// Adds a lump of coral or rock, half sunk into the ground.
void add_lump(SceneBuilder& builder,
              const std::string& name,
              Material material,
              float radius_m,
              const Eigen::Isometry3f& T_place_lump);

// Returns a uniform random float.
inline float draw(base::RandomRow& random, double low, double high) {
    return static_cast<float>(random.uniform(low, high));
}

}  // namespace divemesh::simulator
