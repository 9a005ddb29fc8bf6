#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace divemesh::storage {

// Returns the parts of a key. Throws Error{InvalidArgument} unless the key is made of [a-z0-9._/-],
// has no empty part, no "." and no "..", and is at most 512 bytes with parts of at most 200.
std::vector<std::string> split_key(std::string_view key);

}  // namespace divemesh::storage
