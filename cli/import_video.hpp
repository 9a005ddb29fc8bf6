#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <vector>

#include "cli/command.hpp"
#include "worker/recording/import_video.hpp"

namespace divemesh::cli {

// Adds the options of `import` that videos alone have.
std::shared_ptr<recording::VideoImportOptions> add_video_options(CLI::App& command);

// Turns videos into a dive, and prints what they are and what came of it. The options that
// recordings of all kinds have are taken from `common`. Returns the exit code.
int import_video(const std::vector<std::filesystem::path>& videos,
                 const recording::ImportOptions& common,
                 const recording::VideoImportOptions& video,
                 const Context& context);

}  // namespace divemesh::cli
