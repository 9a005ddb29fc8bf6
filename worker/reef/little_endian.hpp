#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <string_view>

namespace divemesh::reef {

static_assert(std::endian::native == std::endian::little);

// Returns the value at an offset, which must be inside of the bytes.
template <typename Value>
Value little_endian_at(std::string_view bytes, std::size_t offset) {
    Value value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

}  // namespace divemesh::reef
