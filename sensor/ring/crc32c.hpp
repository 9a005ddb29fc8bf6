#pragma once

#include <cstdint>
#include <string_view>

namespace divemesh::sensor {

// Returns the CRC-32C (Castagnoli, RFC 3720); 0 for no bytes.
std::uint32_t crc32c(std::string_view bytes);

}  // namespace divemesh::sensor
