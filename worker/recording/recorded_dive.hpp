#pragma once

#include <filesystem>

#include "worker/base/observer.hpp"

namespace divemesh::recording {

// Returns true for a file that begins as a recording that can be imported.
bool is_recording(const std::filesystem::path& file);

// Returns what dive::Dive::open() opens: `path` itself, or the folder in `scratch` that a recording
// is turned into: a bag or MCAP, or images or videos in a folder or an archive, with the cameras,
// times and calibration that it tells itself. The same recording gives the same dive, whatever its
// file is called. Throws dive::Refusal if it does not tell them, and Error{Cancelled} if `progress`
// does.
std::filesystem::path as_dive(const std::filesystem::path& path,
                              const std::filesystem::path& scratch,
                              const base::ProgressCallback& progress);

}  // namespace divemesh::recording
