#pragma once

#include <optional>
#include <string>

namespace divemesh::storage {

// Returns the text without what a database that takes UTF-8 alone would refuse: invalid bytes and
// zeros become U+FFFD. Returns nullopt for a text that can be stored as it is.
std::optional<std::string> storable_text(const std::string& text);

}  // namespace divemesh::storage
