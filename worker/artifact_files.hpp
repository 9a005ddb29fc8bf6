#pragma once

#include <filesystem>
#include <vector>

#include "schemas/artifact.hpp"

namespace divemesh::worker {

// Every regular file below `folder` in order of name, with hash, size and media type; job and blob
// are left open. Links are left out.
std::vector<Artifact> list_artifacts(const std::filesystem::path& folder);

// Of what a reconstruction leaves, all but what is large and that nothing measures.
bool is_read_again(const std::string& artifact_name);

// A name that does not lead out of its folder, whoever gave it.
bool is_below(const std::filesystem::path& name);

// What tells formats apart (".tum", ".csv", ".ply"): letters and digits alone, else "".
std::string plain_extension(const std::string& file_name);

}  // namespace divemesh::worker
