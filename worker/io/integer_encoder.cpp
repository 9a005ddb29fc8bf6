#include "worker/io/integer_encoder.hpp"

#include <algorithm>
#include <bit>

namespace divemesh::io {
namespace {

constexpr unsigned kMaxBits = 32;
constexpr unsigned kModelledBits = 8;

}  // namespace

IntegerEncoder::IntegerEncoder(std::size_t num_contexts)
    : num_bits_models_(num_contexts, AdaptiveSymbolModel(kMaxBits + 1)) {
    for (unsigned bits = 1; bits < kMaxBits; ++bits)
        place_models_.emplace_back(1U << std::min(bits, kModelledBits));
}

void IntegerEncoder::encode(ArithmeticEncoder& encoder,
                            std::int32_t prediction,
                            std::int32_t value,
                            std::size_t context) {
    const std::uint32_t corrector =
        static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(prediction);
    const bool is_positive = static_cast<std::int32_t>(corrector) > 0;
    num_bits_ = static_cast<unsigned>(std::bit_width(is_positive ? corrector - 1 : 0 - corrector));
    encoder.encode(num_bits_models_[context], num_bits_);
    if (num_bits_ == 0)
        encoder.encode_bit(zero_or_one_, is_positive);
    else if (num_bits_ < kMaxBits)  // there is only one with 32
        encode_place(encoder, is_positive ? corrector - 1 : corrector + (1U << num_bits_) - 1);
}

// `place` is where the corrector lies among those of as many bits, from 0 to 2^k - 1.
void IntegerEncoder::encode_place(ArithmeticEncoder& encoder, std::uint32_t place) {
    AdaptiveSymbolModel& model = place_models_[num_bits_ - 1];
    if (num_bits_ <= kModelledBits) {
        encoder.encode(model, place);
        return;
    }
    const unsigned num_raw_bits = num_bits_ - kModelledBits;
    encoder.encode(model, place >> num_raw_bits);
    encoder.encode_raw(num_raw_bits, place & ((1U << num_raw_bits) - 1));
}

}  // namespace divemesh::io
