#include "worker/io/ply_zip.hpp"

#include <vector>

#include "worker/io/mesh_check.hpp"
#include "worker/io/record.hpp"
#include "worker/io/zip_writer.hpp"

namespace divemesh::io {
namespace {

constexpr std::size_t kChunk_bytes = std::size_t{1} << 20;

// The atlases that triangles refer to, and the number of each in the file.
struct UsedAtlases {
    std::vector<std::size_t> atlases;
    std::vector<std::int32_t> number_of;  // or kUntextured
};

UsedAtlases used_atlases(const StoredTexture& texture) {
    std::vector<bool> is_used(texture.jpegs.size(), false);
    for (const std::int32_t atlas : texture.atlas_of_triangle)
        if (atlas != types::TextureMap::kUntextured) is_used[atlas] = true;
    UsedAtlases used;
    used.number_of.assign(texture.jpegs.size(), types::TextureMap::kUntextured);
    for (std::size_t atlas = 0; atlas < is_used.size(); ++atlas) {
        if (!is_used[atlas]) continue;
        used.number_of[atlas] = static_cast<std::int32_t>(used.atlases.size());
        used.atlases.push_back(atlas);
    }
    return used;
}

std::string header(const types::Mesh& mesh, const UsedAtlases* used, const std::string& remark) {
    std::string text =
        "ply\nformat binary_little_endian 1.0\ncomment divemesh; metres, world frame, z up\n";
    if (!remark.empty()) text.append("comment ").append(remark).append("\n");
    if (used != nullptr)
        for (const std::size_t atlas : used->atlases)
            text.append("comment TextureFile ").append(atlas_file_name(atlas)).append("\n");
    text.append("element vertex ").append(std::to_string(mesh.vertices.size()));
    text +=
        "\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\n";
    if (!mesh.colors.empty())
        text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    text.append("element face ").append(std::to_string(mesh.triangles.size()));
    text += "\nproperty list uchar int vertex_indices\n";
    if (used != nullptr) text += "property list uchar float texcoord\nproperty int texnumber\n";
    return text + "end_header\n";
}

void write_vertices(const types::Mesh& mesh, ZipWriter& zip) {
    const std::vector<Eigen::Vector3f> normals = unit_normals(mesh);
    Record record;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        record.put(mesh.vertices[i]);
        record.put(normals[i]);
        if (!mesh.colors.empty()) record.put(mesh.colors[i]);
        if (record.size_bytes() > kChunk_bytes) record.flush_to(zip);
    }
    record.flush_to(zip);
}

void write_triangles(const types::Mesh& mesh,
                     const StoredTexture* texture,
                     const UsedAtlases& used,
                     ZipWriter& zip) {
    Record record;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        record.put(std::uint8_t{3});
        for (const std::uint32_t vertex : mesh.triangles[i]) record.put(vertex);
        if (texture != nullptr) {
            const std::int32_t atlas = texture->atlas_of_triangle[i];
            const bool is_textured = atlas != types::TextureMap::kUntextured;
            record.put(std::uint8_t{6});
            for (const Eigen::Vector2f& uv : texture->uv[i]) {
                record.put(is_textured ? uv.x() : 0.0F);
                record.put(is_textured ? 1.0F - uv.y() : 0.0F);
            }
            record.put(is_textured ? used.number_of[atlas] : -1);
        }
        if (record.size_bytes() > kChunk_bytes) record.flush_to(zip);
    }
    record.flush_to(zip);
}

}  // namespace

void write_ply_zip(const std::filesystem::path& file,
                   const types::Mesh& mesh,
                   const StoredTexture* texture,
                   const std::string& remark) {
    check_mesh(mesh);
    if (texture != nullptr) check_texture_map(mesh, *texture, texture->jpegs.size());
    const UsedAtlases used = texture == nullptr ? UsedAtlases{} : used_atlases(*texture);
    ZipWriter zip(file);
    zip.begin("mesh.ply");
    zip.write(header(mesh, texture == nullptr ? nullptr : &used, remark));
    write_vertices(mesh, zip);
    write_triangles(mesh, texture, used, zip);
    for (const std::size_t atlas : used.atlases) {
        zip.begin(atlas_file_name(atlas));
        zip.write(texture->jpegs[atlas]);
    }
    zip.commit();
}

}  // namespace divemesh::io
