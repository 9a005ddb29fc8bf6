#pragma once

#include <cstdint>
#include <vector>

namespace divemesh::io {

// Probabilities that follow the symbols coded so far, as the arithmetic coder of LASzip has them
// (Said, "Introduction to Arithmetic Coding", HP Labs HPL-2004-76; Isenburg, "LASzip", 2013). A
// decoder keeps the same counts, so every constant and rounding here is part of the file format.

// The model of a bit. Probabilities are in units of 2^-13.
class AdaptiveBitModel {
public:
    static constexpr unsigned kProbabilityBits = 13;

    std::uint32_t probability_of_zero() const { return probability_; }
    void count(bool bit);

private:
    void update();

    std::uint32_t probability_ = 1U << (kProbabilityBits - 1);
    std::uint32_t num_zeros_ = 1;
    std::uint32_t num_bits_ = 2;
    std::uint32_t cycle_ = 4;  // bits from one update to the next
    std::uint32_t until_update_ = 4;
};

// The model of symbols from 0 to num_symbols - 1. Probabilities are in units of 2^-15.
class AdaptiveSymbolModel {
public:
    static constexpr unsigned kProbabilityBits = 15;

    explicit AdaptiveSymbolModel(std::uint32_t num_symbols);  // 2 to 2048, all as probable

    bool is_last(std::uint32_t symbol) const { return symbol + 1 == counts_.size(); }
    // Returns the probability of all symbols below this one.
    std::uint32_t probability_below(std::uint32_t symbol) const { return below_[symbol]; }
    void count(std::uint32_t symbol);

private:
    void update();

    std::vector<std::uint32_t> counts_;
    std::vector<std::uint32_t> below_;
    std::uint32_t sum_ = 0;  // of the counts at the last update
    std::uint32_t cycle_;    // symbols from one update to the next
    std::uint32_t until_update_ = 0;
};

}  // namespace divemesh::io
