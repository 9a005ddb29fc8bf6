#pragma once

#include <string>
#include <string_view>
#include <yaml-cpp/yaml.h>

namespace divemesh::recording {

// Returns whether a file begins as a zip does, as those of numpy.savez() do.
bool is_npz(std::string_view bytes);

// Reads the arrays of numbers of numpy.savez() and savez_compressed(): each becomes a list of its
// numbers by rows under its name, one number without a list. Arrays of other types, of more than
// two dimensions that are longer than 1, and of more than 4096 numbers are passed over. Throws
// Error{BadData}, which names the file, if it is damaged or holds a number that is not finite.
YAML::Node parse_npz(std::string_view bytes, const std::string& file);

}  // namespace divemesh::recording
