#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace divemesh::recording {

// Returns the numbers of an array as numpy.save() writes it (numpy.lib.format, versions 1 to 3), by
// rows: floating point of 4 or 8 bytes and integers of 4 or 8, in either byte order and either
// order of the elements. Returns nullopt for other types, more than two dimensions that are longer
// than 1, and more than 4096 numbers. Throws Error{BadData} with the reason if the bytes are no
// such array.
std::optional<std::vector<double>> parse_npy(std::string_view bytes);

}  // namespace divemesh::recording
