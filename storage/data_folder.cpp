#include "storage/data_folder.hpp"

namespace divemesh::storage {

namespace fs = std::filesystem;

void create_data_folder(const fs::path& folder, std::error_code& failure) {
    const bool is_new = fs::create_directories(folder, failure);
    if (is_new && !failure)
        fs::permissions(folder, fs::perms::others_all, fs::perm_options::remove, failure);
}

}  // namespace divemesh::storage
