#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "worker/dive/dive.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/dive/port_yaml.hpp"

namespace divemesh::dive {

// Code of the finding for a file that is not valid JSON.
inline constexpr const char* kJsonUnreadable = "json_unreadable";

// Parse dive.json and measurements.json; what cannot be read is left out with a warning. What was
// found when the dive was imported from another form is reported again.
DiveInfo parse_dive_info(std::string_view text, FindingLog& findings);
std::vector<KnownDistance> parse_known_distances(std::string_view text, FindingLog& findings);
// Returns the port of both cameras that dive.json states for those whose sensor.yaml states none;
// nullopt if there is no key `port`, with an error `calibration_port` if it is not an object of
// numbers and lists of numbers.
std::optional<PortYaml> parse_port(std::string_view text, FindingLog& findings);
// Parses markers.json. A mistake is an error that names the field, as a wrong length would scale
// the result.
std::optional<MarkerPlan> parse_markers(std::string_view text, FindingLog& findings);

}  // namespace divemesh::dive
