#pragma once

#include <algorithm>
#include <gmock/gmock.h>
#include <string>

#include "schemas/finding.hpp"

namespace divemesh {

// Prints a finding in the message of a failed test.
inline void PrintTo(const Finding& finding, std::ostream* out) {
    *out << "\n    " << to_string(finding.severity) << " " << finding.code << " at '"
         << finding.where << "': " << finding.message << " | " << finding.remedy;
}

// Matches a list with a finding of this severity and code whose place or message contains `place`.
MATCHER_P3(HasFinding, severity, code, place, "") {
    return std::any_of(arg.begin(), arg.end(), [&](const Finding& finding) {
        const std::string words = finding.where + " " + finding.message;
        return finding.severity == severity && finding.code == std::string(code) &&
               words.find(place) != std::string::npos;
    });
}

}  // namespace divemesh
