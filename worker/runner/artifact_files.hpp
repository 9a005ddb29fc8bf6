#pragma once

#include <filesystem>
#include <vector>

#include "schemas/artifact.hpp"

namespace divemesh::runner {

// Every regular file below `folder` in order of name, with hash, size and media type; job and blob
// are left open. Links are left out.
std::vector<Artifact> list_artifacts(const std::filesystem::path& folder);

// Of what a reconstruction leaves, all but what is large and that nothing measures.
bool is_read_again(const std::string& artifact_name);

// A name that does not lead out of its folder, whoever gave it.
bool is_below(const std::filesystem::path& name);

// A name for a file of ours that people know theirs by: letters, digits and ._- alone, 64 at most,
// the end of a long one, which tells formats apart.
std::string plain_name(const std::string& file_name);

}  // namespace divemesh::runner
