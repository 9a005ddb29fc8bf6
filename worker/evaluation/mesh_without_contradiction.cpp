#include "worker/evaluation/mesh_without_contradiction.hpp"

#include "worker/evaluation/scaled_uncertainty.hpp"

namespace divemesh::evaluation {

types::Mesh mesh_without_contradiction(const io::ReconstructionFolder& folder) {
    const double sigma = contradiction_sigma(folder.scale_contradiction());
    if (sigma == 0.0) return folder.mesh();
    return with_scale_sigma(folder.mesh(), folder.trajectory(), folder.segments(), sigma, 0.0);
}

}  // namespace divemesh::evaluation
