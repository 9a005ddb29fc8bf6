#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace divemesh::bench {

// Returns an SVG of the steps of summarise(), with one panel for each of the given axes. A panel
// shows three lines over its steps, in per cent of the path: our median error, our stated bound,
// and the error of SIFT and PnP. A step whose median tracked share is too low is drawn at the upper
// edge.
std::string envelope_plot(const nlohmann::json& steps, const std::vector<std::string>& axes);

}  // namespace divemesh::bench
