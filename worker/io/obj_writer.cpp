#include "worker/io/obj_writer.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <charconv>
#include <exception>
#include <memory>
#include <string>
#include <string_view>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/mesh_check.hpp"

namespace divemesh::io {
namespace {

constexpr std::size_t kChunk_bytes = std::size_t{1} << 20;
constexpr std::string_view kMaterial =
    "# the colour is that of the vertices\n"
    "newmtl surface\nKa 1 1 1\nKd 1 1 1\nillum 0\n";

// A zip that is written to a file. Errors of the file are passed on unchanged through the library.
class ZipWriter {
public:
    explicit ZipWriter(const std::filesystem::path& file)
        : output_(file), archive_(archive_write_new()) {
        archive_write_set_format_zip(archive_.get());
        archive_write_set_bytes_in_last_block(archive_.get(), 1);
        check(archive_write_open(archive_.get(), this, nullptr, write, nullptr));
    }

    void begin(const char* name) {
        const std::unique_ptr<archive_entry, Free> entry(archive_entry_new());
        archive_entry_set_pathname(entry.get(), name);
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

void write_triangles(ObjText& text, const types::Mesh& mesh) {
    for (const auto& triangle : mesh.triangles) {
        text.add("f");
        for (const std::uint32_t vertex : triangle) {
            text.add(" ");
            text.add_number(vertex + std::uint64_t{1});
            if (mesh.normals.empty()) continue;
            text.add("//");
            text.add_number(vertex + std::uint64_t{1});
        }
        text.add("\n");
    }
}

}  // namespace

void write_obj_zip(const std::filesystem::path& file,
                   const types::Mesh& mesh,
                   const std::string& remark) {
    check_mesh(mesh);
    ZipWriter zip(file);
    zip.begin("mesh.obj");
    ObjText text(zip);
    text.add("# m, z up\n");
    if (!remark.empty()) text.add("# " + remark + "\n");
    text.add("mtllib mesh.mtl\no dive\n");
    write_vertices(text, mesh);
    text.add("usemtl surface\n");
    write_triangles(text, mesh);
    text.flush();
    zip.begin("mesh.mtl");
    zip.add(kMaterial);
    zip.commit();
}

}  // namespace divemesh::io
