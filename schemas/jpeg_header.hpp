#pragma once

#include <string_view>

namespace divemesh {

// Pixels of a JPEG file.
struct JpegSize {
    int width = 0;
    int height = 0;
};

// Walks the markers and reads the frame header (ITU-T T.81, B.1 and B.2.2); no pixel is decoded.
// Throws Error{InvalidArgument} for what is no JPEG, has no picture, or is cut off.
JpegSize read_jpeg_size(std::string_view bytes);

}  // namespace divemesh
