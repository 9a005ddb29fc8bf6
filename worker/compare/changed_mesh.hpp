#pragma once

#include <filesystem>
#include <vector>

#include "worker/compare/m3c2.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::compare {

// Returns the colour of a change: red lost, white unchanged, blue grown, full at `full_m`; grey if
// unknown.
types::Color change_color(double change_m, double full_m);

// Writes changed_mesh.ply, binary little-endian: x y z nx ny nz, red green blue by the distance,
// then distance (M3C2 of b over a along the normal, m; NaN where a has no surface) and lod95 (m).
void write_changed_mesh(const std::filesystem::path& file,
                        const types::Mesh& mesh,
                        const std::vector<M3c2Distance>& distances,
                        double full_m);

}  // namespace divemesh::compare
