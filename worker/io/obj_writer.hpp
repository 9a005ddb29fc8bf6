#pragma once

#include <filesystem>
#include <string>

#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Writes a zip of mesh.obj and mesh.mtl: Wavefront OBJ in m, z up as in all our files. It has
// vertices as `v x y z r g b` (sRGB, 0 to 1: MeshLab, Blender and CloudCompare read the colours,
// other programs ignore them), normals and triangles. `remark` is a comment of one line at the top.
// The same mesh gives the same bytes. Throws as AtomicFile and check_mesh do.
void write_obj_zip(const std::filesystem::path& file,
                   const types::Mesh& mesh,
                   const std::string& remark = "");

}  // namespace divemesh::io
