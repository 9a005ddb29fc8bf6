#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/recording/import_recording.hpp"

namespace divemesh::cli {

// Returns what every import prints as JSON: its findings and counts.
nlohmann::json imported_json(const recording::ImportCounts& counts,
                             const std::vector<Finding>& findings);

// Returns the same as text; `cameras` says how left and right were told, "" if that needs no word.
std::string imported_text(const recording::ImportCounts& counts,
                          const std::vector<Finding>& findings,
                          const std::filesystem::path& out,
                          const std::string& cameras = "");

}  // namespace divemesh::cli
