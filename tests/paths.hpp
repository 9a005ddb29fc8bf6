#pragma once

#include <filesystem>
#include <string>

namespace divemesh {

// The root of the source tree.
std::filesystem::path source_directory();

// A folder of the shared test data ("tank", "barge", "evo" ...): DIVEMESH_SHARED, default
// ../shared. Tests skip with a clear word when it does not exist.
std::filesystem::path shared_data(const std::string& name);

// A file of the shared tools ("flaky_proxy.mjs"), with the same to be said of it.
std::filesystem::path shared_tool(const std::string& name);

}  // namespace divemesh
