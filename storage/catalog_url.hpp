#pragma once

#include <string>

namespace divemesh::storage {

// Returns whether the URL names a PostgreSQL database.
bool is_postgresql_url(const std::string& url);

// Returns the URL of a catalog as it may be shown and logged: with *** for a password.
std::string without_password(const std::string& url);

}  // namespace divemesh::storage
