#pragma once

#include <string_view>

namespace divemesh {

// Returns an embedded text with every character that CMake or C++ could misread.
std::string_view awkward_txt();

}  // namespace divemesh
