#pragma once

#include <cstdint>

namespace divemesh::recording {

// The size of an image in pixels.
struct ImageSize {
    std::int64_t width_px = 0;
    std::int64_t height_px = 0;
};

}  // namespace divemesh::recording
