#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace divemesh::io {

// The checksum of ISO 3309, as PNG, zip and MCAP have it.
class Crc32 {
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
                rest = (rest & 1U) != 0 ? 0xedb88320U ^ (rest >> 1U) : rest >> 1U;
            table[byte] = rest;
        }
        return table;
    }();

    std::uint32_t state_ = ~std::uint32_t{0};
};

}  // namespace divemesh::io
