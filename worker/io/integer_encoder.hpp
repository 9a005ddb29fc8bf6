#pragma once

#include <cstdint>
#include <vector>

#include "worker/io/arithmetic_encoder.hpp"

namespace divemesh::io {

// Encodes integers of 32 bits as what corrects a prediction (Isenburg, "LASzip", 2013, 4.1): first
// the number of bits k of the corrector, which lies in [1 - 2^k, 2^k], then where it lies in this
// interval, of which at most the upper eight bits are modelled.
class IntegerEncoder {
public:
    explicit IntegerEncoder(std::size_t num_contexts);

    // The context chooses the model of the number of bits. Differences wrap around at 2^32.
    void encode(ArithmeticEncoder& encoder,
                std::int32_t prediction,
                std::int32_t value,
                std::size_t context);

    // Returns the number of bits of the last corrector, 0 to 32.
    unsigned num_bits() const { return num_bits_; }

private:
    void encode_place(ArithmeticEncoder& encoder, std::uint32_t place);

    std::vector<AdaptiveSymbolModel> num_bits_models_;  // by context
    AdaptiveBitModel zero_or_one_;
    std::vector<AdaptiveSymbolModel> place_models_;  // by number of bits, from 1 to 31
    unsigned num_bits_ = 0;
};

}  // namespace divemesh::io
