#pragma once

#include <string>
#include <string_view>

namespace divemesh::storage {

// Returns e.g. "dive_" and 20 letters and digits, safe in URLs, file names and blob keys: 11 of
// time, 9 (45 bit) random. Ids of one process sort in the order in which they were made, also
// within a millisecond.
std::string new_id(std::string_view kind);

// Returns `num_bytes` from the kernel's random source, as lower-case hex.
std::string random_hex(std::size_t num_bytes);

}  // namespace divemesh::storage
