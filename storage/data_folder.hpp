#pragma once

#include <filesystem>
#include <system_error>

namespace divemesh::storage {

// Creates a folder for catalog and blobs, closed to other users of the machine: recordings,
// positions and the secrets of webhooks are in it. Leaves one that exists as it is.
void create_data_folder(const std::filesystem::path& folder, std::error_code& failure);

}  // namespace divemesh::storage
