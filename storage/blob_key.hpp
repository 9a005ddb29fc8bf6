#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace divemesh::storage {

// Returns the parts of a key. Throws Error{InvalidArgument} unless the key is made of [a-z0-9._/-],
// has no empty part, no "." and no "..", and is at most 512 bytes with parts of at most 200.
std::vector<std::string> split_key(std::string_view key);

// Returns the folder that a prefix names: without the slash at its end. Throws
// Error{InvalidArgument} unless it ends with one and the rest is a key.
std::string folder_of_prefix(const std::string& prefix);

}  // namespace divemesh::storage
