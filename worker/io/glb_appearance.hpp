#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "worker/io/glb_buffers.hpp"
#include "worker/io/textured_mesh.hpp"

namespace divemesh::io {

// A primitive of a glTF document and what it became in a mesh.
struct GlbPrimitive {
    const nlohmann::json* description = nullptr;
    Eigen::Matrix3d A_world_node = Eigen::Matrix3d::Identity();  // of directions
    std::size_t first_vertex = 0;
    std::size_t num_vertices = 0;
    std::size_t first_triangle = 0;
    std::size_t num_triangles = 0;
};

// Adds the normals, vertex colours and texture of the primitives to their vertices and triangles.
// Throws Error{BadData} that names the file and the problem.
void add_appearance(const nlohmann::json& document,
                    GlbBuffers& buffers,
                    const std::vector<GlbPrimitive>& primitives,
                    const std::string& name,
                    TexturedMesh& textured);

}  // namespace divemesh::io
