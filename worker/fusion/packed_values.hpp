#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

// Compact encodings of the running means and sums of the volumes.
namespace divemesh::fusion {

// A weight, 1/m^2, in 16 bits: 6 of exponent (2^-20 to 2^44), 10 of mantissa; 0 is no weight. A sum
// stops growing when an addend is less than a 4096th of it.
inline constexpr std::int32_t kWeightBase = (127 - 20) << 23;
inline constexpr int kWeightShift = 13;

inline float unpack_weight(std::uint16_t packed) {
    return packed == 0 ? 0.0F : std::bit_cast<float>((packed << kWeightShift) + kWeightBase);
}
inline std::uint16_t pack_weight(float weight) {
    const std::int32_t bits = std::bit_cast<std::int32_t>(weight) - kWeightBase;
    const std::int32_t rounded = (bits + (1 << (kWeightShift - 1))) >> kWeightShift;
    return static_cast<std::uint16_t>(std::clamp(rounded, 1, 0xffff));
}
// Three means in 32 bits, of 11, 11 and 10 bits.
struct PackedTriple {
    static constexpr int kBits[3] = {11, 11, 10};
    static constexpr int kShift[3] = {21, 10, 0};
    static constexpr std::int32_t largest(int i) { return (1 << kBits[i]) - 1; }
    // Returns how many steps of that channel's mean make one grey value.
    static constexpr std::int32_t steps_per_grey(int i) { return 1 << (kBits[i] - 8); }
};

// Returns the i-th mean of a triple, in its own steps.
inline std::int32_t unpack(std::uint32_t triple, int i) {
    return static_cast<std::int32_t>(triple >> PackedTriple::kShift[i]) & PackedTriple::largest(i);
}

// Returns a mean shifted to its place in a triple; combine the three with OR.
inline std::uint32_t packed(std::int32_t value, int i) {
    return static_cast<std::uint32_t>(value) << PackedTriple::kShift[i];
}

// Colours: every mean is stored plus one, so that 0 means no colour.
inline std::uint8_t unpack_grey(std::uint32_t color, int i) {
    return static_cast<std::uint8_t>((unpack(color, i) - 1) / PackedTriple::steps_per_grey(i));
}

// Steps are coarse: a mean moves by at least this share of the way to a new colour, or it would
// stop changing after many views.
inline constexpr float kMinColorShare = 1.0F / 32.0F;

}  // namespace divemesh::fusion
