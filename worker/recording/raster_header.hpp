#pragma once

#include <cstdint>
#include <string_view>

namespace divemesh::recording {

// The size of an image and how its values are written, by its first bytes.
struct RasterHeader {
    std::int64_t width_px = 0;
    std::int64_t height_px = 0;
    std::int64_t max_value = 0;  // that a PGM or PPM states; 0: another format
};

// Reads the header of a TIFF, BMP, PGM or PPM. Throws Error{BadData} if it is neither, or the
// header is damaged or states no size.
RasterHeader read_raster_header(std::string_view bytes);

}  // namespace divemesh::recording
