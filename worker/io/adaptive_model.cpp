#include "worker/io/adaptive_model.hpp"

#include <algorithm>

namespace divemesh::io {
namespace {

// Probabilities are quotients with 31 bits, cut to those of the model.
constexpr std::uint32_t kOne = 1U << 31;

std::uint32_t cut_to(unsigned bits, std::uint32_t probability) {
    return probability >> (31 - bits);
}

std::uint32_t half_rounded_up(std::uint32_t count) { return (count + 1) / 2; }

// Updates become rarer by a quarter each time, down to one in `max` symbols.
std::uint32_t next_cycle(std::uint32_t cycle, std::uint32_t max) {
    return std::min(5 * cycle / 4, max);
}

}  // namespace

void AdaptiveBitModel::count(bool bit) {
    if (!bit) ++num_zeros_;
    if (--until_update_ == 0) update();
}

void AdaptiveBitModel::update() {
    num_bits_ += cycle_;
    if (num_bits_ > 1U << kProbabilityBits) {
        num_bits_ = half_rounded_up(num_bits_);
        num_zeros_ = half_rounded_up(num_zeros_);
        if (num_zeros_ == num_bits_) ++num_bits_;
    }
    probability_ = cut_to(kProbabilityBits, num_zeros_ * (kOne / num_bits_));
    cycle_ = next_cycle(cycle_, 64);
    until_update_ = cycle_;
}

AdaptiveSymbolModel::AdaptiveSymbolModel(std::uint32_t num_symbols)
    : counts_(num_symbols, 1), below_(num_symbols), cycle_(num_symbols) {
    update();
    cycle_ = (num_symbols + 6) / 2;
    until_update_ = cycle_;
}

void AdaptiveSymbolModel::count(std::uint32_t symbol) {
    ++counts_[symbol];
    if (--until_update_ == 0) update();
}

void AdaptiveSymbolModel::update() {
    sum_ += cycle_;
    if (sum_ > 1U << kProbabilityBits) {
        sum_ = 0;
        for (std::uint32_t& count : counts_) sum_ += count = half_rounded_up(count);
    }
    const std::uint32_t scale = kOne / sum_;
    std::uint32_t num_below = 0;
    for (std::size_t symbol = 0; symbol < counts_.size(); ++symbol) {
        below_[symbol] = cut_to(kProbabilityBits, scale * num_below);
        num_below += counts_[symbol];
    }
    cycle_ = next_cycle(cycle_, 8 * (static_cast<std::uint32_t>(counts_.size()) + 6));
    until_update_ = cycle_;
}

}  // namespace divemesh::io
