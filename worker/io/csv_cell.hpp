#pragma once

#include <string>

namespace divemesh::io {

// Returns a text as a cell of RFC 4180, quoted if necessary. A text that a spreadsheet would run as
// a formula is prefixed with an apostrophe.
std::string csv_cell(std::string text);

}  // namespace divemesh::io
