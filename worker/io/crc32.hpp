#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace divemesh::io {

// A checksum of 32 bits whose polynomial is given with the lowest power in the highest bit.
template <std::uint32_t kPolynomial>
class ReflectedCrc32 {
public:
    void add(std::string_view bytes) {
        for (const char byte : bytes)
            state_ = kTable[(state_ ^ static_cast<unsigned char>(byte)) & 0xffU] ^ (state_ >> 8U);
    }
    std::uint32_t value() const { return ~state_; }

private:
    static constexpr std::array<std::uint32_t, 256> kTable = [] {
        std::array<std::uint32_t, 256> table{};
        for (std::uint32_t byte = 0; byte < 256; ++byte) {
            std::uint32_t rest = byte;
            for (int bit = 0; bit < 8; ++bit)
                rest = (rest & 1U) != 0 ? kPolynomial ^ (rest >> 1U) : rest >> 1U;
            table[byte] = rest;
        }
        return table;
    }();

    std::uint32_t state_ = ~std::uint32_t{0};
};

// The checksum of ISO 3309, as PNG, zip and MCAP have it.
using Crc32 = ReflectedCrc32<0xedb88320U>;
// That of iSCSI (RFC 3720), CRC-32C, as E57 has it.
using Crc32c = ReflectedCrc32<0x82f63b78U>;

}  // namespace divemesh::io
