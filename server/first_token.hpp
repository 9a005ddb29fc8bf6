#pragma once

#include <filesystem>
#include <string>

#include "storage/catalog.hpp"

namespace divemesh::server {

// Creates an admin token if the catalog has no token, and writes it to `file`, readable by its
// owner only. Returns the secret, "" if there was a token. Throws Error{Unavailable} if the file
// cannot be written; then it leaves no token.
std::string make_first_token(const storage::Catalog& catalog, const std::filesystem::path& file);

}  // namespace divemesh::server
