#pragma once

#include <cstdio>
#include <string>

namespace divemesh::base {

// A number in a message, with so many places: the same on every machine.
inline std::string fixed(double value, int places) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", places, value);
    return text;
}

// The same with so many significant digits, for numbers of any size.
inline std::string significant(double value, int digits = 4) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

}  // namespace divemesh::base
