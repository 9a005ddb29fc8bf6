#pragma once

#include <string>

namespace divemesh::io {

// A text as a cell of RFC 4180, quoted where it must be. What a spreadsheet would run as a formula
// gets an apostrophe in front.
std::string csv_cell(std::string text);

}  // namespace divemesh::io
