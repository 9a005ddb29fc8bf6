#pragma once

#include <CLI/App.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace divemesh::cli {

// --preset and --set name=value: how a reconstruction is asked for, here and on a server.
struct PresetOptions {
    std::string preset = "standard";
    std::vector<std::string> set;
};

void add_preset_options(CLI::App& command, PresetOptions& options);

// {"voxel_m": 0.01} of "voxel_m=0.01": a value that is no JSON is a string. Throws
// Error{InvalidArgument} without "=".
nlohmann::json overrides_of(const std::vector<std::string>& set);

}  // namespace divemesh::cli
