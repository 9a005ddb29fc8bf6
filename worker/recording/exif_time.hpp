#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace divemesh::recording {

// When a camera took a still, by its EXIF.
struct ExifTime {
    std::int64_t timestamp_ns = 0;  // since 1970; by the camera's own clock where no zone is stated
    bool has_fraction = false;      // false: whole seconds
};

// Returns the time of a still (Exif 2.32: DateTimeOriginal, SubSecTimeOriginal, OffsetTimeOriginal,
// or DateTime where the first is missing) from the first bytes of a JPEG or PNG, or a whole TIFF;
// nullopt if it has none. The reader is our own: it needs six text fields, of TIFF and PNG too, and
// everything is bounded by the bytes given.
std::optional<ExifTime> exif_time(std::string_view image);

}  // namespace divemesh::recording
