#include "worker/pipeline/link_or_copy.hpp"

namespace divemesh::pipeline {

namespace fs = std::filesystem;

void link_or_copy(const fs::path& from, const fs::path& to) {
    fs::create_directories(to.parent_path());
    std::error_code failure;
    fs::remove(to, failure);
    fs::create_hard_link(from, to, failure);
    if (failure) fs::copy_file(from, to);
}

}  // namespace divemesh::pipeline
