#pragma once

#include <string>

#include "schemas/finding.hpp"

namespace divemesh::cli {

// Returns e.g. "error    mav0/cam1/data.csv:3: time goes back (timestamps_backwards)" with the
// remedy below it.
std::string finding_text(const Finding& finding);

}  // namespace divemesh::cli
