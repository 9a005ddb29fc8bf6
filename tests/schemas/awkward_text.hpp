#pragma once

#include <string_view>

namespace divemesh {

// Everything in it that CMake or C++ could take for its own.
std::string_view awkward_txt();

}  // namespace divemesh
