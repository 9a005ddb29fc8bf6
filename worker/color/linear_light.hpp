#pragma once

#include <array>
#include <cstdint>

// The response of the cameras. A recording does not state it, so it is taken to be a power of 2.2,
// which is within a few per cent of sRGB but for its darkest tenth.
namespace divemesh::color {

using Rgb = std::array<float, 3>;  // r g b, linear light; 1 is the white of an 8 bit image

// Returns the linear light of each stored level.
const std::array<float, 256>& linear_levels();

// Returns the level that stores this light, clamped to 0 to 255; 0 for NaN.
std::uint8_t level_of(float linear);

}  // namespace divemesh::color
