#pragma once

#include <cstdint>

#include "worker/base/parallel.hpp"
#include "worker/compare/coarse_alignment.hpp"
#include "worker/compare/point_to_plane_icp.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::compare {

struct CoRegisterOptions {
    double spacing_m = 0.01;  // of the vertices
    int num_threads = 0;
    std::uint64_t seed = 1;
    std::vector<CoarseAlignment> known = {};  // tried before anything is searched for: of markers
};

// Finds where b lies in a's frame with nothing known but the vertical, fits stable surface to
// stable surface and checks the outcome. Throws Error{Conflict} that says what fell short when the
// surfaces do not lie on each other, share too little ground, or would do so in another place as
// well.
CoRegistration co_register(const types::Mesh& a,
                           const types::Mesh& b,
                           const CoRegisterOptions& options,
                           const base::ProgressShare& progress);

}  // namespace divemesh::compare
