#pragma once

#include <filesystem>
#include <string>

#include "worker/base/observer.hpp"

namespace divemesh::dive {

// Returns the identity of the dive in an archive (schemas/content_hash.hpp), in one pass and
// without unpacking to disk. Throws Error{BadData} if the file is not an archive or contains no
// dive, as Dive::open() does.
std::string archive_content_sha256(const std::filesystem::path& archive,
                                   const base::ProgressCallback& progress = base::ignore_progress);

}  // namespace divemesh::dive
