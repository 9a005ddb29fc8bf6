#pragma once

#include <string>
#include <string_view>

namespace divemesh::recording {

// Returns the last run of digits in a name; "" if there is none.
std::string last_number(std::string_view stem);

// Returns the longest number in a name, with the fraction behind a decimal point; "" if there is
// none.
std::string longest_number(std::string_view stem);

}  // namespace divemesh::recording
