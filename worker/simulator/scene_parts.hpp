#pragma once

#include <string>

#include "worker/base/hashed_random.hpp"
#include "worker/simulator/scene.hpp"

// What several scenes are furnished with. Names get the number of the piece appended.
namespace divemesh::simulator {

// Exact box standing on z = 0 of `T_place_box`; measures its length, width and height.
void add_measured_box(SceneBuilder& builder,
                      const std::string& name,
                      Material material,
                      const Eigen::Vector3f& size_m,
                      const Eigen::Isometry3f& T_place_box);
// A bar in 0.1 m segments, black and white, lying along x with its underside at z = 0; measured.
void add_scale_bar(SceneBuilder& builder,
                   const std::string& name,
                   float length_m,
                   const Eigen::Isometry3f& T_place_bar);
// A lump of coral or rock half sunk into its place.
void add_lump(SceneBuilder& builder,
              const std::string& name,
              Material material,
              float radius_m,
              const Eigen::Isometry3f& T_place_lump);

// A float draw.
inline float draw(base::RandomRow& random, double low, double high) {
    return static_cast<float>(random.uniform(low, high));
}

}  // namespace divemesh::simulator
