#pragma once

#include <string>
#include <vector>

namespace divemesh::storage {

// Returns the files of storage/migrations/sqlite in their order, compiled in.
const std::vector<std::string>& sqlite_scripts();

}  // namespace divemesh::storage
