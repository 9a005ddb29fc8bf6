#pragma once

#include <filesystem>

#include "worker/types/mesh.hpp"

namespace divemesh::io {

// A zip of mesh.obj and mesh.mtl: Wavefront OBJ, m, z up as everywhere in our files; vertices as
// `v x y z r g b` (sRGB, 0 to 1: MeshLab, Blender, CloudCompare read the colours, others leave
// them out), normals, triangles. The same bytes for the same mesh. Throws as AtomicFile and
// check_mesh do.
void write_obj_zip(const std::filesystem::path& file, const types::Mesh& mesh);

}  // namespace divemesh::io
