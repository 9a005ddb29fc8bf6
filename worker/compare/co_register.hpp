#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/compare/coarse_alignment.hpp"
#include "worker/compare/point_to_plane_icp.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::compare {

struct CoRegisterOptions {
    double spacing_m = 0.01;  // of the vertices
    int num_threads = 0;
    std::uint64_t seed = 1;
    int max_icp_rounds = IcpOptions{}.max_rounds;
    std::vector<CoarseAlignment> known = {};  // e.g. from markers; tried before any search
    // Says which dives do not know their vertical, for the refusal; empty: both know it.
    std::string without_vertical = {};
};

// Finds the pose of b in a's frame, with only the vertical known: aligns stable surface to stable
// surface and checks the result. Throws Error{Conflict}, which says what failed, if the surfaces do
// not fit each other, share too little ground, or fit in another place as well. A vertical that is
// not known is named as the likely cause.
CoRegistration co_register(const types::Mesh& a,
                           const types::Mesh& b,
                           const CoRegisterOptions& options,
                           const base::ProgressShare& progress);

}  // namespace divemesh::compare
