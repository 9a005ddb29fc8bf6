#pragma once

#include <filesystem>
#include <vector>

#include "schemas/artifact.hpp"

namespace divemesh::worker {

// Every regular file below `folder` in order of name, with hash, size and media type; job and blob
// are left open. Links are left out.
std::vector<Artifact> list_artifacts(const std::filesystem::path& folder);

}  // namespace divemesh::worker
