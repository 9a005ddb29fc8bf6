#include "worker/io/mesh_check.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "schemas/error.hpp"

namespace divemesh::io {
namespace {

void check_length(const char* what, std::size_t length, std::size_t num_vertices) {
    if (length != 0 && length != num_vertices)
        throw Error(ErrorCode::InvalidArgument,
                    std::string("the mesh has ") + std::to_string(length) + " " + what + " for " +
                        std::to_string(num_vertices) + " vertices");
}

std::vector<Eigen::Vector3f> normals_from_triangles(const types::Mesh& mesh) {
    std::vector<Eigen::Vector3f> normals(mesh.vertices.size(), Eigen::Vector3f::Zero());
    for (const auto& triangle : mesh.triangles) {
        const Eigen::Vector3f& a = mesh.vertices[triangle[0]];
        const Eigen::Vector3f normal =
            (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a);
        for (const std::uint32_t vertex : triangle) normals[vertex] += normal;
    }
    return normals;
}

// The comparison is false for values that are not finite.
bool normalise(Eigen::Vector3f& normal) {
    const float length = normal.norm();
    if (!(length > 1e-20F && length < 1e20F)) return false;
    normal /= length;
    return true;
}

}  // namespace

void check_mesh(const types::Mesh& mesh) {
    const std::size_t num_vertices = mesh.vertices.size();
    check_length("normals", mesh.normals.size(), num_vertices);
    check_length("colors", mesh.colors.size(), num_vertices);
    check_length("sigmas", mesh.sigma_m.size(), num_vertices);
    check_length("local sigmas", mesh.sigma_local_m.size(), num_vertices);
    check_length("voxels", mesh.voxel_m.size(), num_vertices);
    check_length("observation counts", mesh.num_observations.size(), num_vertices);
    const auto is_finite = [](const Eigen::Vector3f& vertex) { return vertex.allFinite(); };
    if (!std::all_of(mesh.vertices.begin(), mesh.vertices.end(), is_finite))
        throw Error(ErrorCode::InvalidArgument, "the mesh has a vertex that is not finite");
    for (const auto& triangle : mesh.triangles)
        if (*std::max_element(triangle.begin(), triangle.end()) >= num_vertices)
            throw Error(ErrorCode::InvalidArgument,
                        "the mesh has a triangle with a vertex that does not exist");
}

void check_texture_map(const types::Mesh& mesh,
                       const types::TextureMap& texture,
                       std::size_t num_atlases) {
    const std::size_t num_triangles = mesh.triangles.size();
    if (texture.atlas_of_triangle.size() != num_triangles || texture.uv.size() != num_triangles)
        throw Error(ErrorCode::InvalidArgument, "the texture is of a mesh with other triangles");
    const auto is_inside = [](const Eigen::Vector2f& uv) {
        return (uv.array() >= 0.0F).all() && (uv.array() <= 1.0F).all();
    };
    for (std::size_t i = 0; i < num_triangles; ++i) {
        const std::int32_t atlas = texture.atlas_of_triangle[i];
        if (atlas == types::TextureMap::kUntextured) continue;
        if (atlas < 0 || atlas >= static_cast<std::int64_t>(num_atlases) ||
            !std::all_of(texture.uv[i].begin(), texture.uv[i].end(), is_inside))
            throw Error(ErrorCode::InvalidArgument,
                        "the texture has a triangle outside of its atlases");
    }
}

void check_texture(const types::Mesh& mesh, const types::Texture& texture) {
    for (const cv::Mat& atlas : texture.atlases)
        if (atlas.empty() || atlas.type() != CV_8UC3 || atlas.cols > kMaxAtlas_px ||
            atlas.rows > kMaxAtlas_px)
            throw Error(ErrorCode::InvalidArgument,
                        "the texture has an atlas that is not a BGR image of 1 to 8192 px a side");
    check_texture_map(mesh, texture, texture.atlases.size());
}

std::vector<Eigen::Vector3f> unit_normals(const types::Mesh& mesh) {
    std::vector<Eigen::Vector3f> from_triangles;
    std::vector<Eigen::Vector3f> normals = mesh.normals;
    normals.resize(mesh.vertices.size(), Eigen::Vector3f::Zero());
    for (std::size_t i = 0; i < normals.size(); ++i) {
        if (normalise(normals[i])) continue;
        if (from_triangles.empty()) from_triangles = normals_from_triangles(mesh);
        normals[i] = from_triangles[i];
        if (!normalise(normals[i])) normals[i] = Eigen::Vector3f::UnitZ();
    }
    return normals;
}

}  // namespace divemesh::io
