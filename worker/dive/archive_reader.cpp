#include "worker/dive/archive_reader.hpp"

#include <new>

namespace divemesh::dive {

std::string_view plain_entry_name(std::string_view name) {
    while (name.starts_with("./")) name.remove_prefix(2);
    return name;
}

ArchiveReader make_archive_reader() {
    ArchiveReader reader(archive_read_new(), &archive_read_free);
    if (reader == nullptr) throw std::bad_alloc();
    archive_read_support_format_tar(reader.get());
    archive_read_support_format_zip_seekable(reader.get());
    archive_read_support_filter_gzip(reader.get());
    archive_read_support_filter_zstd(reader.get());
    return reader;
}

}  // namespace divemesh::dive
