#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "worker/simulator/rendering.hpp"
#include "worker/simulator/water.hpp"
#include "worker/types/camera.hpp"

namespace divemesh::simulator {

// Particles that drift through the water near the cameras, the same in both cameras. The lamps
// light them at close range; out of focus they are discs.
class MarineSnow {
public:
    MarineSnow(double particles_per_m3, std::uint64_t seed);

    // Draws the snow that a camera sees into the radiance of a rendering, in front of its depth,
    // and marks it in its mask of snow.
    void draw(const types::Camera& camera,
              const Eigen::Isometry3d& T_world_cam,
              double t_s,
              const Water& water,
              Rendering& rendering) const;

private:
    struct Particle {
        Eigen::Vector3d start;
        Eigen::Vector3d drift;  // m/s
        double radius_m;
        float brightness;
    };
    std::vector<Particle> particles_;
};

}  // namespace divemesh::simulator
