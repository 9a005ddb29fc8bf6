#include "worker/io/obj_writer.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <charconv>
#include <exception>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/mesh_check.hpp"
#include "worker/io/mesh_part.hpp"

namespace divemesh::io {
namespace {

constexpr std::size_t kChunk_bytes = std::size_t{1} << 20;
// A zip that is written to a file. Errors of the file are passed on unchanged through the library.
class ZipWriter {
public:
    explicit ZipWriter(const std::filesystem::path& file)
        : output_(file), archive_(archive_write_new()) {
        archive_write_set_format_zip(archive_.get());
        archive_write_set_bytes_in_last_block(archive_.get(), 1);
        check(archive_write_open(archive_.get(), this, nullptr, write, nullptr));
    }

    void begin(const std::string& name) {
        const std::unique_ptr<archive_entry, Free> entry(archive_entry_new());
        archive_entry_set_pathname(entry.get(), name.c_str());
        archive_entry_set_filetype(entry.get(), AE_IFREG);
        archive_entry_set_perm(entry.get(), 0644);
        archive_entry_set_mtime(entry.get(), kNoTime_s, 0);
        check(archive_write_header(archive_.get(), entry.get()));
    }
    void add(std::string_view text) {
        if (archive_write_data(archive_.get(), text.data(), text.size()) < 0) check(ARCHIVE_FATAL);
    }
    void commit() {
        check(archive_write_close(archive_.get()));
        output_.commit();
    }

private:
    // 1980-01-01, the first time of the zip format
    static constexpr time_t kNoTime_s = 315'532'800;

    struct Free {
        void operator()(archive* zip) const { archive_write_free(zip); }
        void operator()(archive_entry* entry) const { archive_entry_free(entry); }
    };

    static la_ssize_t write(archive*, void* self, const void* bytes, std::size_t size) {
        auto& zip = *static_cast<ZipWriter*>(self);
        try {
            zip.output_.write({static_cast<const char*>(bytes), size});
            return static_cast<la_ssize_t>(size);
        } catch (...) {
            zip.error_ = std::current_exception();
            return -1;
        }
    }
    void check(int result) {
        if (error_) std::rethrow_exception(error_);
        if (result < ARCHIVE_WARN)
            throw Error(
                ErrorCode::Unavailable,
                std::string("cannot write the zip: ") + archive_error_string(archive_.get()));
    }

    base::AtomicFile output_;
    std::exception_ptr error_;
    std::unique_ptr<archive, Free> archive_;
};

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
        zip_.add(text_);
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

std::string image_name(std::size_t atlas) { return "atlas_" + std::to_string(atlas) + ".jpg"; }

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
    zip.add("# the colour of surface is that of the vertices\nnewmtl surface\n");
    zip.add(kUnlit);
    for (const std::size_t atlas : atlases) {
        zip.add("newmtl atlas_" + std::to_string(atlas) + "\n");
        zip.add(kUnlit);
        zip.add("map_Kd " + image_name(atlas) + "\n");
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
        zip.begin(image_name(atlas));
        zip.add(texture->jpegs[atlas]);
    }
    zip.commit();
}

}  // namespace divemesh::io
