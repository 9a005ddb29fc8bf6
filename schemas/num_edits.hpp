#pragma once

#include <cstddef>
#include <string_view>

namespace divemesh {

// Returns how many characters must be inserted, removed or replaced to turn one text into the other
// (Levenshtein).
std::size_t num_edits(std::string_view a, std::string_view b);

}  // namespace divemesh
