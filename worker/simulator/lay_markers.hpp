#pragma once

#include "worker/geometry/rig.hpp"
#include "worker/markers/marker_plan.hpp"
#include "worker/simulator/diver_motion.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::worker {

// Lays boards with tags 0, 1, 2, ... on the ground where the left camera looks on its way, at least
// two boards apart, on the slope that they find. The plan holds their printed size and the exact
// distances of neighbours and of every second one. Throws Error{InvalidArgument} when there is no
// room for as many.
MarkerPlan lay_markers(const SimulateOptions& options,
                       const Rig& rig,
                       const DiverMotion& motion,
                       Scene& scene);

}  // namespace divemesh::worker
