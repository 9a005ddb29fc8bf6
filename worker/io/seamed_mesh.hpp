#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::io {

// Some triangles of a mesh with what a viewer shows, and with vertices of their own.
struct SeamedPart {
    types::Mesh mesh;
    types::TextureMap map;
};

// A mesh to be shown in parts and with fewer triangles. Its vertices are repeated where texture
// coordinates differ from triangle to triangle, so that each vertex has one place in the texture.
class SeamedMesh {
public:
    using Triangles = std::vector<std::array<std::uint32_t, 3>>;

    // `texture` is null for a mesh that has the colours of its vertices.
    SeamedMesh(const types::Mesh& mesh, const types::TextureMap* texture, std::size_t num_atlases);

    const std::vector<Eigen::Vector3f>& vertices() const { return mesh_.vertices; }
    const Triangles& triangles() const { return mesh_.triangles; }
    SeamedPart part(const Triangles& triangles) const;
    // Returns the triangles with edges collapsed up to a quadric error, while their border stays
    // and both sides of a seam remain together.
    Triangles simplified(const Triangles& triangles, double max_error_m) const;

private:
    types::Mesh mesh_;
    std::vector<std::int32_t> atlas_;  // of each vertex
    std::vector<Eigen::Vector2f> uv_;
};

}  // namespace divemesh::io
