#pragma once

#include <CLI/App.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace divemesh::cli {

// --preset and --set name=value: the options of a reconstruction, here and on a server.
struct PresetOptions {
    std::string preset = "standard";
    std::vector<std::string> set;
};

// Adds --preset and --set.
void add_preset_options(CLI::App& command, PresetOptions& options);

// Parses "voxel_m=0.01" into {"voxel_m": 0.01}; a value that is not JSON is a string. Throws
// Error{InvalidArgument} without "=".
nlohmann::json overrides_of(const std::vector<std::string>& set);

}  // namespace divemesh::cli
