#pragma once

#include <cstddef>
#include <functional>

#include "worker/fusion/signed_distance_field.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::mesh {

// Calls work(index) for each index below `num` in parallel. This is the part from `begin` to `end`,
// 0 to 1, of what `settings.progress` reports. Each report also releases memory of the field.
void run_phase(const fusion::SignedDistanceField& field,
               const MeshingSettings& settings,
               double begin,
               double end,
               std::size_t num,
               const std::function<void(std::size_t)>& work);

}  // namespace divemesh::mesh
