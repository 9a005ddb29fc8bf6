#pragma once

#include <filesystem>
#include <string>

namespace divemesh::pipeline {

// A file that says from what the files beside it were made, for a stage whose files cannot say so
// themselves. Written last: where it is, they are whole. save throws Error{OutOfSpace}.
void save_stage_key(const std::filesystem::path& file, const std::string& key);
bool has_stage_key(const std::filesystem::path& file, const std::string& key);

}  // namespace divemesh::pipeline
