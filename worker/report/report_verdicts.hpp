#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "schemas/metric.hpp"
#include "schemas/requirement.hpp"

namespace divemesh::report {

// Returns "requirements" of report.json. A requirement on a missing metric is not met. If
// `unusable` states why the result is not usable, none is met, for that reason.
nlohmann::json judge_requirements(const std::vector<Requirement>& requirements,
                                  const std::vector<Metric>& metrics,
                                  const std::string& unusable = "");

// Returns "passed": whether all are met; null if there are none.
nlohmann::json passed(const nlohmann::json& requirements);

// Returns "regressions": metrics that are worse than their history allows. The history needs at
// least three values. Worse means beyond the median by more than three robust standard deviations
// (1.4826 median absolute deviations) and by more than 10 % of it. Errors and stated uncertainties
// are worse when their absolute value is larger; coverage, inlier shares and counts when they are
// smaller; other metrics are neither good nor bad.
nlohmann::json find_regressions(const std::map<std::string, std::vector<double>>& history,
                                const std::vector<Metric>& metrics);

}  // namespace divemesh::report
