#pragma once

#include <string>
#include <vector>

namespace divemesh::simulator {

// A part of a dive in which something differs.
struct Stretch {
    double at_share = 0.0;    // where it begins: 0 the start of the dive, 1 its end
    double duration_s = 0.0;  // how long it takes
};

// Reads stretches such as "0:10,0.5:4" (10 s at the start, 4 s from the middle on). Throws
// Error{InvalidArgument} for anything else, and for stretches that are out of order.
std::vector<Stretch> stretches_from_string(const std::string& text);

}  // namespace divemesh::simulator
