#include "schemas/finding.hpp"

#include <algorithm>

#include "schemas/enum_text.hpp"

namespace divemesh {
namespace {

constexpr EnumText<Severity> kTexts[] = {
    {Severity::Info, "info"},
    {Severity::Warning, "warning"},
    {Severity::Error, "error"},
};

}  // namespace

std::string_view to_string(Severity severity) { return enum_to_text(kTexts, severity); }

Severity severity_from_string(std::string_view text) {
    return enum_from_text<Severity>(kTexts, text, "severity");
}

bool has_error(const std::vector<Finding>& findings) {
    return std::any_of(findings.begin(), findings.end(), [](const Finding& finding) {
        return finding.severity == Severity::Error;
    });
}

}  // namespace divemesh
