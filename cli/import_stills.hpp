#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <vector>

#include "cli/command.hpp"
#include "worker/recording/import_stills.hpp"

namespace divemesh::cli {

// Adds the options of `import` that folders of images alone have.
std::shared_ptr<recording::StillsOptions> add_stills_options(CLI::App& command);

// Imports one or two folders of images. The options that recordings of all kinds have are taken
// from `common`. Returns the exit code.
int import_stills(const std::vector<std::filesystem::path>& folders,
                  const recording::ImportOptions& common,
                  const recording::StillsOptions& stills,
                  const Context& context);

}  // namespace divemesh::cli
