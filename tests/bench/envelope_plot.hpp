#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace divemesh::bench {

// Returns the steps of summarise() as SVG, one panel for each of these axes: the median error in
// per cent of the path over its steps, ours, what we state, and that of SIFT and PnP. A step whose
// median frame is lost is at the upper edge.
std::string envelope_plot(const nlohmann::json& steps, const std::vector<std::string>& axes);

}  // namespace divemesh::bench
