#pragma once

#include <string>
#include <string_view>

#include "schemas/error.hpp"

namespace divemesh {

enum class Comparison { LessOrEqual, GreaterOrEqual, Less, Greater };

// A requirement of a report: "drift_percent<=0.5".
struct Requirement {
    std::string text;    // as written
    std::string metric;  // its full name, see schemas/metric.hpp
    Comparison comparison = Comparison::LessOrEqual;
    double limit = 0.0;  // in the metric's unit
};

// Parses METRIC<=NUMBER, with <=, >=, < or >, and blanks around each part. Throws
// Error{InvalidArgument} for another form, a limit that is not a finite number, and an unknown
// metric (with similar names).
Requirement parse_requirement(std::string_view text);

bool is_met(const Requirement& requirement, double value);

}  // namespace divemesh
