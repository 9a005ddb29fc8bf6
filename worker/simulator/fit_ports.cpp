#include "worker/simulator/fit_ports.hpp"

#include <cmath>

#include "worker/base/angle.hpp"
#include "worker/camera/water_index.hpp"

namespace divemesh::simulator {
namespace {

constexpr double kAcrylic = 1.49;

// `outside`: -1 for the left camera, 1 for the right one.
types::Port port_of(const SimulatedPorts& ports, double outside, double water_index) {
    const double tilt_rad = ports.tilt_deg * base::kRadPerDeg;
    types::Port port;
    port.shape = ports.shape;
    port.thickness_m = ports.thickness_m;
    port.glass_index = kAcrylic;
    port.water_index = water_index;
    if (ports.shape == types::Port::Shape::Flat) {
        port.normal = {outside * std::sin(tilt_rad), 0.0, std::cos(tilt_rad)};
        port.distance_m = ports.distance_m;
    } else {
        port.centre_m = {0.0, 0.0, -ports.offset_m};
        port.radius_m = ports.radius_m;
    }
    return port;
}

}  // namespace

types::Rig fit_ports(types::Rig rig, const SimulateOptions& options) {
    if (!options.ports) return rig;
    const double water_index = camera::water_index(kWater_c, options.salinity_psu);
    rig.cam0.port = port_of(*options.ports, -1.0, water_index);
    rig.cam1.port = port_of(*options.ports, 1.0, water_index);
    return rig;
}

}  // namespace divemesh::simulator
