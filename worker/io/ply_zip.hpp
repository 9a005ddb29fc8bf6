#pragma once

#include <filesystem>
#include <string>

#include "worker/io/textured_mesh.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Writes a zip of mesh.ply and the JPEGs of the atlases that are in use, unchanged. The PLY is
// binary, in m, z up, and has texture coordinates as MeshLab and CloudCompare read them: a comment
// `TextureFile NAME` for each image, and for each triangle the six values of `texcoord`, v up, and
// `texnumber`, the comment that it refers to or -1 without texture. So vertices stay shared at
// seams and a triangle can name one of several images, which coordinates of vertices (s, t) cannot
// do. Without texture (null) it has the colours of the vertices alone. `remark` is a comment of one
// line. The same mesh gives the same bytes. Throws as AtomicFile, check_mesh and check_texture_map
// do.
void write_ply_zip(const std::filesystem::path& file,
                   const types::Mesh& mesh,
                   const StoredTexture* texture,
                   const std::string& remark);

}  // namespace divemesh::io
