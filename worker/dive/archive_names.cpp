#include "worker/dive/archive_names.hpp"

#include <algorithm>
#include <archive_entry.h>
#include <cstdint>
#include <fcntl.h>

#include "schemas/file_descriptor.hpp"
#include "worker/dive/archive_reader.hpp"

namespace divemesh::dive {
namespace {

constexpr std::size_t kBlock_bytes = std::size_t{1} << 18U;

}  // namespace

void look_through_archive(const std::filesystem::path& archive,
                          const DiveLimits& limits,
                          const std::function<bool(std::string_view name)>& look) {
    const FileDescriptor file(::open(archive.c_str(), O_RDONLY | O_CLOEXEC));
    const ArchiveReader reader = make_archive_reader();
    if (!file.is_open() ||
        archive_read_open_fd(reader.get(), file.get(), kBlock_bytes) != ARCHIVE_OK)
        return;
    std::error_code unknown;
    const auto packed_bytes = static_cast<double>(std::filesystem::file_size(archive, unknown));
    const double max_bytes = std::min(static_cast<double>(limits.max_unpacked_bytes),
                                      limits.max_compression_ratio * std::max(packed_bytes, 1.0) +
                                          static_cast<double>(kRatioCheckedFromBytes));
    archive_entry* entry = nullptr;
    for (std::int64_t number = 0; number < limits.max_entries; ++number) {
        const int result = archive_read_next_header(reader.get(), &entry);
        if ((result != ARCHIVE_OK && result != ARCHIVE_WARN) ||
            archive_filter_count(reader.get()) > kMaxArchiveFilters ||
            static_cast<double>(archive_filter_bytes(reader.get(), 0)) > max_bytes)
            return;
        const char* name = archive_entry_pathname(entry);
        if (name != nullptr && !look(plain_entry_name(name))) return;
    }
}

}  // namespace divemesh::dive
