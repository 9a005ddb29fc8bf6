#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "schemas/metric.hpp"
#include "schemas/requirement.hpp"

namespace divemesh::report {

// "requirements" of report.json. What is not to be had is not met.
nlohmann::json judge_requirements(const std::vector<Requirement>& requirements,
                                  const std::vector<Metric>& metrics);

// "passed": whether all are met; null when there are none.
nlohmann::json passed(const nlohmann::json& requirements);

// "regressions": figures that are worse than their history allows, of which at least three values
// are asked: beyond the median by more than three robust standard deviations (1.4826 median
// absolute deviations) and by more than 10 % of it. Errors and stated uncertainties are worse when
// they are larger, by their size whatever their sign; coverage, shares of what fits and counts of
// what was found when they are smaller; other figures are neither good nor bad.
nlohmann::json find_regressions(const std::map<std::string, std::vector<double>>& history,
                                const std::vector<Metric>& metrics);

}  // namespace divemesh::report
