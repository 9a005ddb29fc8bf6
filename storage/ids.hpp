#pragma once

#include <string>
#include <string_view>

namespace divemesh::storage {

// "dive_" and 20 random letters and digits (100 bit): safe in URLs, file names and blob keys.
std::string new_id(std::string_view kind);

// `num_bytes` from the kernel's random source, as lower-case hex.
std::string random_hex(std::size_t num_bytes);

}  // namespace divemesh::storage
