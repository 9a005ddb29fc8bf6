#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "worker/reef/outline_file.hpp"

namespace divemesh::reef {

// Returns the regions that were drawn on one map of a TagLab project (Pavoni et al. 2022), with
// their names and classes as the columns name and label, and the working area as a quadrat. `map`
// names one of several maps; it may be empty if there is one. Throws Error{BadData} that names the
// region, Error{InvalidArgument} with the names of the maps if `map` is none of them.
OutlineFile taglab_outlines(const nlohmann::json& project, const std::string& map);

}  // namespace divemesh::reef
