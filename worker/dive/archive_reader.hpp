#pragma once

#include <archive.h>
#include <cstdint>
#include <memory>
#include <string_view>

namespace divemesh::dive {

// Filters can be stacked, and each layer multiplies the size of a decompression bomb: what is
// stored and one layer are read.
inline constexpr int kMaxArchiveFilters = 2;
// Less than this unpacked is no bomb, however small it was packed.
inline constexpr std::int64_t kRatioCheckedFromBytes = std::int64_t{64} << 20U;

using ArchiveReader = std::unique_ptr<::archive, int (*)(::archive*)>;

// Returns the name of an entry without the "./" that tar puts before it.
std::string_view plain_entry_name(std::string_view name);

// Returns a reader of the archives that dives come in, which is not open yet: zip, tar, tar.gz and
// tar.zst.
ArchiveReader make_archive_reader();

}  // namespace divemesh::dive
