#pragma once

#include "cli/command.hpp"
#include "worker/recording/import_video.hpp"

namespace divemesh::cli {

// Turns videos into a dive, prints what they are and what came of it, and returns the exit code.
int run_video_import(const recording::VideoImportOptions& options, const Context& context);

}  // namespace divemesh::cli
