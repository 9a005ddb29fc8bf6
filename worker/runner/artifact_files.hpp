#pragma once

#include <filesystem>
#include <vector>

#include "schemas/artifact.hpp"

namespace divemesh::runner {

// Returns every regular file below `folder`, sorted by name, with hash, size and media type; job
// and blob are left empty. Links are skipped.
std::vector<Artifact> list_artifacts(const std::filesystem::path& folder);

// Returns whether reports and comparisons read an artifact of a reconstruction again; false for
// large artifacts that no measurement uses.
bool is_read_again(const std::string& artifact_name);

// Returns whether a relative name stays inside its folder; the name may be untrusted.
bool is_below(const std::filesystem::path& name);

// Returns a safe name for our copy of a user's file: only letters, digits and ._-, at most 64
// characters. Of a long name the end is kept, which distinguishes formats.
std::string plain_name(const std::string& file_name);

}  // namespace divemesh::runner
