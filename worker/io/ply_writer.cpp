#include "worker/io/mesh_check.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/record.hpp"

namespace divemesh::io {
namespace {

constexpr char kColorHeader[] = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

std::string header_start(std::size_t num_vertices, const std::string& remark) {
    return "ply\nformat binary_little_endian 1.0\n"
           "comment divemesh; metres, world frame, z up\n" +
           (remark.empty() ? "" : "comment " + remark + "\n") + "element vertex " +
           std::to_string(num_vertices) +
           "\nproperty float x\nproperty float y\nproperty float z\n";
}

std::string mesh_header(const types::Mesh& mesh) {
    return header_start(mesh.vertices.size(), "") +
           "property float nx\nproperty float ny\nproperty float nz\n" +
           (mesh.colors.empty() ? "" : kColorHeader) +
           "property float sigma\nproperty float sigma_local\nproperty uint num_observations\n"
           "element face " +
           std::to_string(mesh.triangles.size()) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
}

}  // namespace

void write_ply(const std::filesystem::path& file, const types::Mesh& mesh) {
    check_mesh(mesh);
    const std::vector<Eigen::Vector3f> normals = unit_normals(mesh);
    base::AtomicFile output(file);
    output.write(mesh_header(mesh));
    Record record;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        record.put(mesh.vertices[i]);
        record.put(normals[i]);
        if (!mesh.colors.empty()) record.put(mesh.colors[i]);
        record.put(mesh.sigma_m.empty() ? 0.0F : mesh.sigma_m[i]);
        record.put(mesh.sigma_local_m.empty() ? 0.0F : mesh.sigma_local_m[i]);
        record.put(mesh.num_observations.empty() ? 0U : mesh.num_observations[i]);
        record.flush_to(output);
    }
    for (const auto& triangle : mesh.triangles) {
        record.put(std::uint8_t{3});
        for (const std::uint32_t vertex : triangle) record.put(vertex);
        record.flush_to(output);
    }
    output.commit();
}

CloudPlyWriter::CloudPlyWriter(const std::filesystem::path& file,
                               std::int64_t num_points,
                               const std::string& remark)
    : output_(file) {
    output_.write(header_start(static_cast<std::size_t>(num_points), remark) + kColorHeader +
                  "end_header\n");
}

void CloudPlyWriter::add(const Eigen::Vector3f& p_world, const types::Color& color) {
    Record record;
    record.put(p_world);
    record.put(color);
    record.flush_to(output_);
}

}  // namespace divemesh::io
