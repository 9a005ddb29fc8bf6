#pragma once

#include <string>
#include <string_view>

#include "schemas/error.hpp"

namespace divemesh {

enum class Comparison { LessOrEqual, GreaterOrEqual, Less, Greater };

// What a report has to fulfil: "drift_percent<=0.5".
struct Requirement {
    std::string text;    // as written
    std::string metric;  // its full name, see schemas/figure.hpp
    Comparison comparison = Comparison::LessOrEqual;
    double limit = 0.0;  // in the figure's unit
};

// FIGURE<=NUMBER, with <=, >=, < or >; blanks around each part. Throws Error{InvalidArgument} for
// another form, a limit that is no finite number, and a figure that is not known (with similar
// names).
Requirement parse_requirement(std::string_view text);

bool is_met(const Requirement& requirement, double value);

}  // namespace divemesh
