#pragma once

#include <filesystem>
#include <string>

#include "worker/io/textured_mesh.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Writes a zip of mesh.obj, mesh.mtl and the JPEGs of the atlases that are in use, unchanged:
// Wavefront OBJ in m, z up as in all our files. It has vertices as `v x y z r g b` (sRGB, 0 to 1:
// MeshLab, Blender and CloudCompare read the colours, other programs ignore them), normals, and the
// triangles of each atlas with their texture coordinates, then those without texture; without
// texture (null) all are that. `remark` is a comment of one line at the top. The same mesh gives
// the same bytes. Throws as AtomicFile, check_mesh and check_texture_map do.
void write_obj_zip(const std::filesystem::path& file,
                   const types::Mesh& mesh,
                   const StoredTexture* texture,
                   const std::string& remark = "");

}  // namespace divemesh::io
