#pragma once

#include <filesystem>

namespace divemesh::pipeline {

// Makes `to` what the file `from` is, by a hard link where the file system allows, and its folder
// when missing. Neither may be changed in place after that.
void link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace divemesh::pipeline
