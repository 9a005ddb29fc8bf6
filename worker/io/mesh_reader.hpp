#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "worker/io/textured_mesh.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Reads a reference from another program, a mesh or only points: PLY, Wavefront OBJ or glTF 2.0
// binary (GLB), distinguished by the first bytes. Throws Error{NotFound}, Error{TooLarge} beyond 4
// GiB, and Error{BadData} that names the file and the problem.
types::Mesh read_mesh(const std::filesystem::path& file);

// Parses the lines v, with colours after x y z if present, and f, split into triangle fans; other
// lines are skipped. Indices count from 1, negative ones back from the last vertex.
types::Mesh parse_obj(std::string_view bytes, const std::string& name);

// Reads the triangles and points of all primitives of the scene, transformed by their nodes.
// It decodes KHR_mesh_quantization and EXT_meshopt_compression. External buffers, other
// compressions and morphing are not supported. glTF's y-up metres become z-up.
types::Mesh parse_glb(std::string_view bytes, const std::string& name);

// Reads a GLB as write_glb makes it, with normals, vertex colours, texture coordinates and the
// JPEGs of its materials, in their order. Vertices of equal position and normal, which the file
// repeats at the seams of the texture, become one. The result has colours and normals if any of its
// triangles has; a vertex of textured triangles alone is white. Throws as read_mesh does.
TexturedMesh read_textured_glb(const std::filesystem::path& file);
TexturedMesh parse_textured_glb(std::string_view bytes, const std::string& name);

}  // namespace divemesh::io
