#pragma once

#include <filesystem>
#include <string>

#include "worker/base/observer.hpp"

namespace divemesh::dive {

// The identity of the dive in an archive (schemas/content_hash.hpp): one pass, nothing unpacked to
// disk. Throws Error{BadData} when it is no archive or holds no dive, as Dive::open() does.
std::string archive_content_sha256(const std::filesystem::path& archive,
                                   const base::ProgressCallback& progress = base::ignore_progress);

}  // namespace divemesh::dive
