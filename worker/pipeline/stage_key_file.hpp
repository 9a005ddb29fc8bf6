#pragma once

#include <filesystem>
#include <string>

namespace divemesh::pipeline {

// A file with the key of the files beside it, for a stage whose files cannot contain the key
// themselves. It is written last: if it exists, they are complete. save throws Error{OutOfSpace}.
void save_stage_key(const std::filesystem::path& file, const std::string& key);
// Returns true if the file exists and has this key.
bool has_stage_key(const std::filesystem::path& file, const std::string& key);

}  // namespace divemesh::pipeline
