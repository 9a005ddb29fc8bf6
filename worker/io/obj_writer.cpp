#include "worker/io/obj_writer.hpp"

#include <charconv>
#include <string>
#include <string_view>
#include <vector>

#include "worker/io/mesh_check.hpp"
#include "worker/io/mesh_part.hpp"
#include "worker/io/zip_writer.hpp"

namespace divemesh::io {
namespace {

constexpr std::size_t kChunk_bytes = std::size_t{1} << 20;

// Writes text in chunks, so that a mesh of gigabytes needs no additional memory.
class ObjText {
public:
    explicit ObjText(ZipWriter& zip) : zip_(zip) {}
    ObjText(const ObjText&) = delete;
    ObjText& operator=(const ObjText&) = delete;

    void add(std::string_view text) {
        text_ += text;
        if (text_.size() > kChunk_bytes) flush();
    }
    template <typename Number>
    void add_number(Number value) {
        char digits[48];
        const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
        add(std::string_view(digits, static_cast<std::size_t>(end - digits)));
    }
    void add_row(std::string_view word, const Eigen::Vector3f& v) {
        add(word);
        for (const float value : v) {
            add(" ");
            add_number(value);
        }
    }
    void flush() {
        zip_.write(text_);
        text_.clear();
    }

private:
    ZipWriter& zip_;
    std::string text_;
};

void write_vertices(ObjText& text, const types::Mesh& mesh) {
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        text.add_row("v", mesh.vertices[i]);
        if (!mesh.colors.empty()) {
            const types::Color& color = mesh.colors[i];
            text.add_row("", Eigen::Vector3f(color[0], color[1], color[2]) / 255.0F);
        }
        text.add("\n");
    }
    for (const Eigen::Vector3f& normal : mesh.normals) {
        text.add_row("vn", normal);
        text.add("\n");
    }
}

// Writes a part with texture coordinates that are numbered from `first_uv`. OBJ's v points up.
void write_part(ObjText& text,
                const types::Mesh& mesh,
                const MeshPart& part,
                std::uint64_t first_uv) {
    for (const Eigen::Vector2f& uv : part.uv) {
        text.add("vt ");
        text.add_number(uv.x());
        text.add(" ");
        text.add_number(1.0F - uv.y());
        text.add("\n");
    }
    for (const auto& triangle : part.triangles) {
        text.add("f");
        for (const std::uint32_t corner : triangle) {
            const std::uint64_t vertex = part.mesh_vertex[corner] + std::uint64_t{1};
            text.add(" ");
            text.add_number(vertex);
            if (!part.uv.empty() || !mesh.normals.empty()) text.add("/");
            if (!part.uv.empty()) text.add_number(first_uv + corner);
            if (mesh.normals.empty()) continue;
            text.add("/");
            text.add_number(vertex);
        }
        text.add("\n");
    }
}

// Writes mesh.obj. Returns the atlases that it uses.
std::vector<std::size_t> write_obj(ZipWriter& zip,
                                   const types::Mesh& mesh,
                                   const StoredTexture* texture,
                                   const std::string& remark) {
    zip.begin("mesh.obj");
    ObjText text(zip);
    text.add("# m, z up\n");
    if (!remark.empty()) text.add("# " + remark + "\n");
    text.add("mtllib mesh.mtl\no dive\n");
    write_vertices(text, mesh);
    std::vector<std::size_t> used;
    std::uint64_t first_uv = 1;
    const std::size_t num_atlases = texture == nullptr ? 0 : texture->jpegs.size();
    for (std::size_t atlas = 0; atlas < num_atlases; ++atlas) {
        const MeshPart part = mesh_part(mesh, texture, static_cast<std::int32_t>(atlas));
        if (part.triangles.empty()) continue;
        used.push_back(atlas);
        text.add("usemtl atlas_" + std::to_string(atlas) + "\n");
        write_part(text, mesh, part, first_uv);
        first_uv += part.uv.size();
    }
    text.add("usemtl surface\n");
    write_part(text, mesh, mesh_part(mesh, texture, types::TextureMap::kUntextured), first_uv);
    text.flush();
    return used;
}

void write_materials(ZipWriter& zip, const std::vector<std::size_t>& atlases) {
    constexpr std::string_view kUnlit = "Ka 1 1 1\nKd 1 1 1\nillum 0\n";
    zip.begin("mesh.mtl");
    zip.write("# the colour of surface is that of the vertices\nnewmtl surface\n");
    zip.write(kUnlit);
    for (const std::size_t atlas : atlases) {
        zip.write("newmtl atlas_" + std::to_string(atlas) + "\n");
        zip.write(kUnlit);
        zip.write("map_Kd " + atlas_file_name(atlas) + "\n");
    }
}

}  // namespace

void write_obj_zip(const std::filesystem::path& file,
                   const types::Mesh& mesh,
                   const StoredTexture* texture,
                   const std::string& remark) {
    check_mesh(mesh);
    if (texture != nullptr) check_texture_map(mesh, *texture, texture->jpegs.size());
    ZipWriter zip(file);
    const std::vector<std::size_t> atlases = write_obj(zip, mesh, texture, remark);
    write_materials(zip, atlases);
    for (const std::size_t atlas : atlases) {
        zip.begin(atlas_file_name(atlas));
        zip.write(texture->jpegs[atlas]);
    }
    zip.commit();
}

}  // namespace divemesh::io
