#include "worker/io/zip_writer.hpp"

#include "schemas/error.hpp"

namespace divemesh::io {
namespace {

constexpr time_t kNoTime_s = 315'532'800;  // 1980-01-01, the first time of the zip format

}  // namespace

ZipWriter::ZipWriter(const std::filesystem::path& file)
    : output_(file), archive_(archive_write_new()) {
    archive_write_set_format_zip(archive_.get());
    archive_write_set_bytes_in_last_block(archive_.get(), 1);
    check(archive_write_open(archive_.get(), this, nullptr, write_to_file, nullptr));
}

void ZipWriter::begin(const std::string& name) {
    const std::unique_ptr<archive_entry, Free> entry(archive_entry_new());
    archive_entry_set_pathname(entry.get(), name.c_str());
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    archive_entry_set_mtime(entry.get(), kNoTime_s, 0);
    check(archive_write_header(archive_.get(), entry.get()));
}

void ZipWriter::write(std::string_view bytes) {
    if (archive_write_data(archive_.get(), bytes.data(), bytes.size()) < 0) check(ARCHIVE_FATAL);
}

void ZipWriter::commit() {
    check(archive_write_close(archive_.get()));
    output_.commit();
}

la_ssize_t ZipWriter::write_to_file(archive*, void* self, const void* bytes, std::size_t size) {
    auto& zip = *static_cast<ZipWriter*>(self);
    try {
        zip.output_.write({static_cast<const char*>(bytes), size});
        return static_cast<la_ssize_t>(size);
    } catch (...) {
        zip.error_ = std::current_exception();
        return -1;
    }
}

void ZipWriter::check(int result) {
    if (error_) std::rethrow_exception(error_);
    if (result < ARCHIVE_WARN)
        throw Error(ErrorCode::Unavailable,
                    std::string("cannot write the zip: ") + archive_error_string(archive_.get()));
}

}  // namespace divemesh::io
