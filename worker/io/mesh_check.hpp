#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::io {

inline constexpr int kMaxAtlas_px = 8192;  // a side, which every graphics card takes

// Throws Error{InvalidArgument} if a triangle uses a vertex that does not exist, a coordinate is
// not finite, or an attribute differs in length from the vertices.
void check_mesh(const types::Mesh& mesh);

// Throws Error{InvalidArgument} if the texture is not one of the mesh: other triangles, atlases
// that do not exist, coordinates outside of their atlas.
void check_texture_map(const types::Mesh& mesh,
                       const types::TextureMap& texture,
                       std::size_t num_atlases);

// Does the same, and throws too if an atlas is not a BGR image of 1 to 8192 px.
void check_texture(const types::Mesh& mesh, const types::Texture& texture);

// Returns the mesh's normals at unit length. A missing or degenerate normal is replaced by the
// area-weighted mean of the triangles around the vertex, or by the upward vector if that is
// degenerate too.
std::vector<Eigen::Vector3f> unit_normals(const types::Mesh& mesh);

}  // namespace divemesh::io
