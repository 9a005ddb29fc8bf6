#pragma once

#include "worker/simulator/simulate.hpp"

namespace divemesh::simulator {

// Throws what simulate() states for options out of range and for a folder that is not empty.
void check_options(const SimulateOptions& options);

}  // namespace divemesh::simulator
