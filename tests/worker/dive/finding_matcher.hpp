#pragma once

#include <algorithm>
#include <gmock/gmock.h>
#include <string>

#include "schemas/finding.hpp"

namespace divemesh {

// Prints a finding when a test fails.
inline void PrintTo(const Finding& finding, std::ostream* out) {
    *out << "\n    " << to_string(finding.severity) << " " << finding.code << " at '"
         << finding.where << "': " << finding.message << " | " << finding.remedy;
}

namespace worker {

// Matches a list of findings that contains one with this severity and code, and with `place` in its
// location or message.
MATCHER_P3(HasFinding, severity, code, place, "") {
    return std::any_of(arg.begin(), arg.end(), [&](const Finding& finding) {
        const std::string words = finding.where + " " + finding.message;
        return finding.severity == severity && finding.code == std::string(code) &&
               words.find(place) != std::string::npos;
    });
}

}  // namespace worker
}  // namespace divemesh
