#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "schemas/finding.hpp"

namespace divemesh {

// What a reconstruction can be used for.
enum class Verdict { Good, UsableWithRestrictions, NotUsable };

// Returns "good", "usable_with_restrictions" or "not_usable".
std::string_view to_string(Verdict verdict);
Verdict verdict_from_string(std::string_view text);  // throws Error{InvalidArgument}

// Returns what a finding restricts: "path", "scale", "surface", "accuracy" or "place"; an error
// restricts "all". "": the finding restricts nothing, although its cause is worth mending.
std::string_view restriction_of(const Finding& finding);

// Returns the verdict on a reconstruction, given all findings on its dive and on itself: not usable
// with an error among them, usable with restrictions if one of them restricts something. No other
// function decides this.
Verdict verdict_on(const std::vector<Finding>& findings);

std::optional<Finding> first_error(const std::vector<Finding>& findings);

// Returns what the findings restrict, each once, in the order of the findings; "all" alone with an
// error among them.
std::vector<std::string_view> restrictions_of(const std::vector<Finding>& findings);

}  // namespace divemesh
