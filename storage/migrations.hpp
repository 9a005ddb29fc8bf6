#pragma once

#include <string>
#include <vector>

namespace divemesh::storage {

// The scripts that bring the schema of an engine up to date, in their order: the first one makes
// version `first_version`, each further one the next version.
struct Migrations {
    int first_version = 1;
    const std::vector<std::string>& scripts;

    int newest_version() const { return first_version + static_cast<int>(scripts.size()) - 1; }
};

}  // namespace divemesh::storage
