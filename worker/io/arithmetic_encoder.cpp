#include "worker/io/arithmetic_encoder.hpp"

#include <utility>

namespace divemesh::io {
namespace {

constexpr std::uint32_t kMinLength = 1U << 24;  // below it, the first byte of `low` is settled

}  // namespace

void ArithmeticEncoder::encode_bit(AdaptiveBitModel& model, bool bit) {
    const std::uint32_t zero =
        (length_ >> AdaptiveBitModel::kProbabilityBits) * model.probability_of_zero();
    if (bit) {
        advance(zero);
        length_ -= zero;
    } else {
        length_ = zero;
    }
    give_out_settled_bytes();
    model.count(bit);
}

void ArithmeticEncoder::encode(AdaptiveSymbolModel& model, std::uint32_t symbol) {
    const std::uint32_t unit = length_ >> AdaptiveSymbolModel::kProbabilityBits;
    const std::uint32_t begin = unit * model.probability_below(symbol);
    // The last symbol has what rounding left of the interval too.
    const std::uint32_t end =
        model.is_last(symbol) ? length_ : unit * model.probability_below(symbol + 1);
    advance(begin);
    length_ = end - begin;
    give_out_settled_bytes();
    model.count(symbol);
}

void ArithmeticEncoder::encode_raw(unsigned num_bits, std::uint32_t bits) {
    constexpr unsigned kMaxAtOnce = 19;
    if (num_bits > kMaxAtOnce) {
        encode_raw(16, bits & 0xFFFF);
        bits >>= 16;
        num_bits -= 16;
    }
    length_ >>= num_bits;
    advance(bits * length_);
    give_out_settled_bytes();
}

std::string ArithmeticEncoder::finish() {
    // A decoder looks four bytes ahead. These are the low end of the interval itself.
    for (const unsigned shift : {24U, 16U, 8U, 0U})
        bytes_.push_back(static_cast<char>(low_ >> shift));
    low_ = 0;
    length_ = 0xFFFF'FFFF;
    return std::exchange(bytes_, {});
}

void ArithmeticEncoder::advance(std::uint32_t offset) {
    low_ += offset;
    if (low_ < offset) carry();
}

void ArithmeticEncoder::carry() {
    auto byte = bytes_.rbegin();
    for (; *byte == '\xFF'; ++byte) *byte = '\0';
    ++*byte;
}

void ArithmeticEncoder::give_out_settled_bytes() {
    for (; length_ < kMinLength; length_ <<= 8) {
        bytes_.push_back(static_cast<char>(low_ >> 24));
        low_ <<= 8;
    }
}

}  // namespace divemesh::io
