#pragma once

#include <string_view>

namespace divemesh {

// Size of a JPEG image, px.
struct JpegSize {
    int width = 0;
    int height = 0;
};

// Returns the size from the frame header (ITU-T T.81, B.1 and B.2.2), without decoding pixels.
// Throws Error{InvalidArgument} for a file that is not JPEG, has no image, or is truncated.
JpegSize read_jpeg_size(std::string_view bytes);

}  // namespace divemesh
