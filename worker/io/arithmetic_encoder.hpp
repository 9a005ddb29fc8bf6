#pragma once

#include <cstdint>
#include <string>

#include "worker/io/adaptive_model.hpp"

namespace divemesh::io {

// The arithmetic encoder of LASzip: an interval of 32 bits that each symbol narrows to its share,
// and whose leading bytes are given out as soon as they are settled (sources: adaptive_model.hpp).
class ArithmeticEncoder {
public:
    void encode_bit(AdaptiveBitModel& model, bool bit);
    void encode(AdaptiveSymbolModel& model, std::uint32_t symbol);
    // Encodes 1 to 32 bits that are as likely as any others.
    void encode_raw(unsigned num_bits, std::uint32_t bits);

    // Ends the code; returns its bytes and starts anew.
    std::string finish();

private:
    void advance(std::uint32_t offset);
    void carry();
    void give_out_settled_bytes();

    std::string bytes_;
    std::uint32_t low_ = 0;  // of the interval, after the bytes that were given out
    std::uint32_t length_ = 0xFFFF'FFFF;
};

}  // namespace divemesh::io
