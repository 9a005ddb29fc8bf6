#pragma once

#include <Eigen/Core>

#include "worker/simulator/simulate.hpp"
#include "worker/simulator/surface_color.hpp"

namespace divemesh::simulator {

// The effect of water on light over a range r, per channel (Akkaynak and Treibitz 2018):
//     I = J exp(-attenuation r) + veil (1 - exp(-backscatter r))
struct Water {
    Rgb attenuation_per_m = Rgb::Zero();
    Rgb backscatter_per_m = Rgb::Zero();
    Rgb veil = Rgb::Zero();     // colour of water at infinite range
    Rgb ambient = Rgb::Ones();  // light from the whole sky at the depth of the scene
    Rgb sun = Rgb::Ones();      // light from the sun's direction
    Rgb strobe = Rgb::Zero();   // of each lamp of the rig, at 1 m
    float exposure = 1.0F;
    bool is_water = false;

    Rgb look_through(const Rgb& radiance, float range_m) const {
        if (!is_water) return radiance;
        return radiance * (-attenuation_per_m * range_m).exp() +
               veil * (1.0F - (-backscatter_per_m * range_m).exp());
    }
};

// Returns the optical properties of a kind of water.
Water make_water(WaterKind kind);

}  // namespace divemesh::simulator
