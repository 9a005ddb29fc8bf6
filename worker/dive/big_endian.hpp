#pragma once

#include <cstdint>
#include <string_view>

namespace divemesh::dive {

// Returns the unsigned big-endian number in `length` bytes of an image file. The bytes must exist.
inline std::int64_t big_endian(std::string_view bytes, std::size_t offset, std::size_t length) {
    std::int64_t value = 0;
    for (std::size_t i = 0; i < length; ++i)
        value = value << 8 | static_cast<unsigned char>(bytes[offset + i]);
    return value;
}

}  // namespace divemesh::dive
