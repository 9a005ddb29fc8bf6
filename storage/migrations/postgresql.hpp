#pragma once

#include <string>
#include <vector>

namespace divemesh::storage {

// Returns the files of storage/migrations/postgresql in their order, compiled in.
const std::vector<std::string>& postgresql_scripts();

}  // namespace divemesh::storage
