#pragma once

#include <filesystem>

#include "worker/base/observer.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/video/indexed_video.hpp"

namespace divemesh::recording {

// Reads a video without decoding it, with the chapters of the same recording that lie beside it,
// and reports what is special about its files. A chapter that cannot follow ends the video before
// it. Throws as read_index() does for the given file.
video::IndexedVideo read_video(const std::filesystem::path& path,
                               dive::FindingLog& findings,
                               const base::ProgressCallback& progress);

}  // namespace divemesh::recording
