#pragma once

#include <numbers>

namespace divemesh::base {

inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;

}  // namespace divemesh::base
