#pragma once

#include <string>
#include <vector>

namespace divemesh::storage {

// Returns the files of storage/migrations in their order, compiled in: the n-th brings the schema
// from version n to n + 1.
const std::vector<std::string>& migrations();

}  // namespace divemesh::storage
