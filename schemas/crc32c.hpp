#pragma once

#include <boost/crc.hpp>
#include <cstdint>
#include <string_view>

namespace divemesh {

// The CRC-32C (Castagnoli, RFC 3720) of bytes that come in parts.
using Crc32c = boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true>;

// Returns the CRC-32C of all bytes; 0 for no bytes.
inline std::uint32_t crc32c(std::string_view bytes) {
    Crc32c crc;
    crc.process_bytes(bytes.data(), bytes.size());
    return crc.checksum();
}

}  // namespace divemesh
