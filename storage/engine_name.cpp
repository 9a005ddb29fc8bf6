#include "storage/engine_name.hpp"

#include <soci/soci.h>

namespace divemesh::storage {

std::string engine_name(Catalog& catalog) {
    std::string name;
    catalog.read([&](soci::session& session) { name = session.get_backend_name(); });
    return name == "sqlite3" ? "sqlite" : name;
}

}  // namespace divemesh::storage
