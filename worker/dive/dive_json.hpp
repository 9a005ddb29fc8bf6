#pragma once

#include <string_view>
#include <vector>

#include "worker/dive/dive.hpp"
#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

inline constexpr const char* kJsonUnreadable = "json_unreadable";  // a finding: nothing of it is

// dive.json and measurements.json; what cannot be read is a warning and left out.
DiveInfo parse_dive_info(std::string_view text, FindingLog& findings);
std::vector<KnownDistance> parse_known_distances(std::string_view text, FindingLog& findings);
// markers.json; what is wrong in it is an error that names the field: a length that is not what
// was meant would scale the result.
std::optional<MarkerPlan> parse_markers(std::string_view text, FindingLog& findings);

}  // namespace divemesh::dive
