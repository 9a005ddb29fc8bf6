#pragma once

#include <filesystem>
#include <string>

namespace divemesh {

// Returns the root of the source tree.
std::filesystem::path source_directory();

// Returns a folder of the shared test data ("tank", "barge", "evo" ...) below DIVEMESH_SHARED, by
// default ../shared. It may be missing: tests then skip and say why.
std::filesystem::path shared_data(const std::string& name);

// Returns a file of the shared tools ("flaky_proxy.mjs"), which may be missing too.
std::filesystem::path shared_tool(const std::string& name);

}  // namespace divemesh
