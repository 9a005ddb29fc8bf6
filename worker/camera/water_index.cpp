#include "worker/camera/water_index.hpp"

namespace divemesh::camera {

double water_index(double temperature_c, double salinity_psu) {
    constexpr double kWavelength_nm = 532.0;
    const double t = temperature_c;
    const double s = salinity_psu;
    return 1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s - 2.02e-6 * t * t +
           (15.868 + 0.01155 * s - 0.00423 * t) / kWavelength_nm -
           4382.0 / (kWavelength_nm * kWavelength_nm) +
           1.1455e6 / (kWavelength_nm * kWavelength_nm * kWavelength_nm);
}

}  // namespace divemesh::camera
