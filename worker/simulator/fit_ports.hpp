#pragma once

#include "worker/simulator/simulate.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::simulator {

inline constexpr double kWater_c = 14.0;  // of the water of all simulated dives

// Returns the rig with the ports of the options before its cameras, in their water. The origin of a
// camera stays that of its lens. Without ports the rig stays.
types::Rig fit_ports(types::Rig rig, const SimulateOptions& options);

}  // namespace divemesh::simulator
