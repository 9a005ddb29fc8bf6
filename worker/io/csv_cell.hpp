#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace divemesh::io {

// Returns a text as a cell of RFC 4180, quoted if necessary. A text that a spreadsheet would run as
// a formula is prefixed with an apostrophe.
std::string csv_cell(std::string text);

// Returns a JSON value as a cell: null is an empty cell, a string its text, all else as JSON.
std::string csv_cell_of(const nlohmann::json& value);

}  // namespace divemesh::io
