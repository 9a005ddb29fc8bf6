#include "cli/findings_text.hpp"

namespace divemesh::cli {

std::string finding_text(const Finding& finding) {
    std::string severity(to_string(finding.severity));
    severity.resize(9, ' ');
    std::string text = severity;
    if (!finding.where.empty()) text += finding.where + ": ";
    text += finding.message + " (" + finding.code + ")\n";
    if (!finding.remedy.empty()) text += "         " + finding.remedy + "\n";
    return text;
}

}  // namespace divemesh::cli
