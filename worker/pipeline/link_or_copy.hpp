#pragma once

#include <filesystem>

namespace divemesh::pipeline {

// Makes `to` the same file as `from` by a hard link, or by a copy if the file system has no links.
// Creates the folder of `to` if missing. Neither file may be changed in place afterwards.
void link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace divemesh::pipeline
