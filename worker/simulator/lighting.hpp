#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "worker/simulator/noise_field.hpp"
#include "worker/simulator/ray_caster.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/simulator/surface_color.hpp"
#include "worker/simulator/water.hpp"

namespace divemesh::simulator {

// The share of sky and sun light that reaches each vertex of a static scene, computed once with
// rays.
class BakedLight {
public:
    // `check_cancelled` is called many times a second, between the threads' work; its exceptions
    // are passed on.
    BakedLight(const Scene& scene,
               const RayCaster& caster,
               const Eigen::Vector3f& to_sun,
               const std::function<void()>& check_cancelled);

    float sky(std::uint32_t vertex) const { return sky_[vertex]; }  // 0 to 1
    float sun(std::uint32_t vertex) const { return sun_[vertex]; }  // 0 to 1

private:
    std::vector<float> sky_;
    std::vector<float> sun_;
};

// Returns the sunlight as focused by waves: a moving net of bright lines, mean about 1.
float caustic(const NoiseField& noise,
              const Eigen::Vector3f& p_world,
              const Eigen::Vector3f& to_sun,
              float t_s,
              float footprint_m);

}  // namespace divemesh::simulator
