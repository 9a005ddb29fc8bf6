#pragma once

namespace divemesh::camera {

// Returns the refractive index of water relative to air, for green light (532 nm), which water
// swallows least: Quan and Fry, "Empirical equation for the index of refraction of seawater",
// Applied Optics 34 (1995), equation 3. It holds from 0 to 30 degrees and 0 to 35 psu; a psu is a
// gram of salt in a kilogram of water.
double water_index(double temperature_c, double salinity_psu);

}  // namespace divemesh::camera
