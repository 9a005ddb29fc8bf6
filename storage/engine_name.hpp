#pragma once

#include <string>

#include "storage/catalog.hpp"

namespace divemesh::storage {

// Returns the kind of database behind a catalog: "sqlite" or "postgresql".
std::string engine_name(Catalog& catalog);

}  // namespace divemesh::storage
