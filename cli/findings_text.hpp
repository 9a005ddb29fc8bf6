#pragma once

#include <string>
#include <vector>

#include "schemas/finding.hpp"

namespace divemesh::cli {

// Returns e.g. "error    mav0/cam1/data.csv:3: time goes back (timestamps_backwards)" with the
// remedy below it.
std::string finding_text(const Finding& finding);

// Returns e.g. "usable with restrictions: path, scale", from the words of metrics.json.
std::string verdict_words(const std::string& verdict, const std::vector<std::string>& restrictions);

// Returns the findings of a reconstruction, errors first, and its verdict as the last line: e.g.
// "verdict: usable with restrictions: path (tracking_lost), scale (scale_untested)".
std::string verdict_text(const std::vector<Finding>& findings);

}  // namespace divemesh::cli
