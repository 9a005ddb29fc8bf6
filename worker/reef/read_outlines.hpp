#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "worker/reef/outline_file.hpp"

namespace divemesh::reef {

// Reads a file of areas, whose format its content tells: returns the document if it is areas.json,
// else the outlines of GeoJSON, a shapefile (with .dbf and .prj beside it) or a map of a TagLab
// project. Throws Error{NotFound} or Error{BadData} that says what to do.
std::variant<nlohmann::json, OutlineFile> read_outlines(const std::filesystem::path& file,
                                                        const std::string& map);

}  // namespace divemesh::reef
