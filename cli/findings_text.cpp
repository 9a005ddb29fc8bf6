#include "cli/findings_text.hpp"

#include <algorithm>

#include "schemas/verdict.hpp"

namespace divemesh::cli {
namespace {

std::string words_of(std::string_view text) {
    std::string words(text);
    std::replace(words.begin(), words.end(), '_', ' ');
    return words;
}

// Returns the codes of the findings that restrict a part, each once.
std::string codes_of(const std::vector<Finding>& findings, std::string_view restricted) {
    std::vector<std::string_view> codes;
    std::string text;
    for (const Finding& finding : findings) {
        if (restriction_of(finding) != restricted ||
            std::find(codes.begin(), codes.end(), finding.code) != codes.end())
            continue;
        text += (codes.empty() ? "" : ", ") + finding.code;
        codes.push_back(finding.code);
    }
    return text;
}

}  // namespace

std::string finding_text(const Finding& finding) {
    std::string severity(to_string(finding.severity));
    severity.resize(9, ' ');
    std::string text = severity;
    if (!finding.where.empty()) text += finding.where + ": ";
    text += finding.message + " (" + finding.code + ")\n";
    if (!finding.remedy.empty()) text += "         " + finding.remedy + "\n";
    return text;
}

std::string verdict_words(const std::string& verdict,
                          const std::vector<std::string>& restrictions) {
    std::string text = words_of(verdict);
    const char* separator = ": ";
    for (const std::string& restricted : restrictions) {
        if (restricted == "all") continue;
        text += separator + restricted;
        separator = ", ";
    }
    return text;
}

std::string verdict_text(const std::vector<Finding>& findings) {
    std::vector<Finding> sorted = findings;
    std::stable_sort(sorted.begin(), sorted.end(), [](const Finding& a, const Finding& b) {
        return a.severity > b.severity;
    });
    std::string text;
    for (const Finding& finding : sorted) text += finding_text(finding);
    text += "verdict: " + words_of(to_string(verdict_on(findings)));
    const char* separator = ": ";
    for (const std::string_view restricted : restrictions_of(findings)) {
        text += separator + std::string(restricted) + " (" + codes_of(findings, restricted) + ")";
        separator = ", ";
    }
    return text + "\n";
}

}  // namespace divemesh::cli
