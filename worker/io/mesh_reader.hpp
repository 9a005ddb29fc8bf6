#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "worker/types/mesh.hpp"

namespace divemesh::io {

// A reference from another program: PLY, Wavefront OBJ or glTF 2.0 binary (GLB), told apart by
// their first bytes; a mesh, or points alone. Throws Error{NotFound}, Error{TooLarge} beyond
// 4 GiB, and Error{BadData} that names the file and what is wrong in it.
types::Mesh read_mesh(const std::filesystem::path& file);

// v, with colours after x y z if they are there, and f, cut into fans; the other lines are passed
// over. Indices from 1, negative ones from the last vertex backwards.
types::Mesh parse_obj(std::string_view bytes, const std::string& name);

// Triangles and points of all primitives of the scene, moved by their nodes; no other buffers
// than the one inside, no compression, no morphing. glTF's y-up metres become z-up.
types::Mesh parse_glb(std::string_view bytes, const std::string& name);

}  // namespace divemesh::io
