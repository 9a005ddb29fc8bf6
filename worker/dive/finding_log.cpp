#include "worker/dive/finding_log.hpp"

#include <algorithm>
#include <utility>

namespace divemesh::dive {

constexpr std::int64_t kKeptOfOneCode = 10;

void FindingLog::error(std::string code,
                       std::string where,
                       std::string message,
                       std::string remedy) {
    add({Severity::Error,
         std::move(code),
         std::move(where),
         std::move(message),
         std::move(remedy)});
}

void FindingLog::warning(std::string code,
                         std::string where,
                         std::string message,
                         std::string remedy) {
    add({Severity::Warning,
         std::move(code),
         std::move(where),
         std::move(message),
         std::move(remedy)});
}

void FindingLog::info(std::string code, std::string where, std::string message) {
    add({Severity::Info, std::move(code), std::move(where), std::move(message), ""});
}

void FindingLog::add(Finding finding) {
    const std::int64_t num_seen = ++num_seen_[finding.code];
    if (num_seen <= kKeptOfOneCode) {
        findings_.push_back(std::move(finding));
        return;
    }
    const auto [summary, is_new] = summary_index_.try_emplace(finding.code, findings_.size());
    if (is_new) findings_.push_back(finding);
    Finding& rest = findings_[summary->second];
    rest.severity = std::max(rest.severity, finding.severity);
    rest.where = "";
    rest.message = "and " + std::to_string(num_seen - kKeptOfOneCode) + " more of this kind";
}

}  // namespace divemesh::dive
