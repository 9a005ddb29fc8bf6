#pragma once

#include <cstdio>
#include <limits>
#include <string>

namespace divemesh::base {

// Returns a number as text with `places` decimals, the same on every machine.
inline std::string fixed(double value, int places) {
    char text[std::numeric_limits<double>::max_exponent10 + 64];
    std::snprintf(text, sizeof text, "%.*f", places, value);
    return text;
}

// Returns a number of any size as text with `digits` significant digits.
inline std::string significant(double value, int digits = 4) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

}  // namespace divemesh::base
