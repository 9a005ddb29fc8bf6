#pragma once

#include <filesystem>
#include <string>

#include "storage/catalog.hpp"

namespace divemesh::server {

// Makes an admin token when the catalog has none, and writes it to `file`, which its owner alone
// may read. Returns the secret, "" when there was a token. Throws Error{Unavailable} when the file
// cannot be written; no token is left then.
std::string make_first_token(const storage::Catalog& catalog, const std::filesystem::path& file);

}  // namespace divemesh::server
