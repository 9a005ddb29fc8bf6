#include "worker/report/report_verdicts.hpp"

#include <algorithm>
#include <cmath>

#include "schemas/known_metric.hpp"
#include "worker/base/text.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

const Metric* find(const std::vector<Metric>& metrics, const std::string& name) {
    const auto found = std::find_if(
        metrics.begin(), metrics.end(), [&](const Metric& metric) { return metric.name == name; });
    return found == metrics.end() ? nullptr : &*found;
}

std::string missing_reason(const std::string& name) {
    if (name.starts_with("surface."))
        return "not available: it needs a surface, ground truth and a reference";
    if (name.starts_with("trajectory.") || name.starts_with("truth."))
        return "not available: it needs ground truth";
    if (name.starts_with("known_distances."))
        return "not available: it needs known distances with both ends seen";
    return "not available for this reconstruction";
}

}  // namespace

json judge_requirements(const std::vector<Requirement>& requirements,
                        const std::vector<Metric>& metrics,
                        const std::string& unusable) {
    json verdicts = json::array();
    for (const Requirement& requirement : requirements) {
        const Metric* metric = find(metrics, requirement.metric);
        json verdict = {{"text", requirement.text},
                        {"figure", requirement.metric},
                        {"value", nullptr},
                        {"met", false},
                        {"reason", missing_reason(requirement.metric)}};
        if (metric != nullptr && !metric->value && metric->method.starts_with("refused: "))
            verdict["reason"] = metric->method;
        if (metric != nullptr && metric->value) {
            const bool met = is_met(requirement, *metric->value);
            verdict["value"] = *metric->value;
            verdict["met"] = met;
            verdict["reason"] = met ? ""
                                    : "it is " + base::significant(*metric->value, 6) +
                                          (metric->unit == "1" ? "" : " " + metric->unit);
        }
        if (!unusable.empty()) {
            verdict["met"] = false;
            verdict["reason"] = unusable;
        }
        verdicts.push_back(std::move(verdict));
    }
    return verdicts;
}

json passed(const json& requirements) {
    if (requirements.empty()) return nullptr;
    return std::all_of(requirements.begin(), requirements.end(), [](const json& requirement) {
        return requirement.at("met").get<bool>();
    });
}

json find_regressions(const std::map<std::string, std::vector<double>>& history,
                      const std::vector<Metric>& metrics) {
    constexpr std::size_t kMinValues = 3;
    constexpr double kSigmas = 3.0;
    constexpr double kTolerated = 0.1;
    json regressions = json::array();
    for (const auto& [name, earlier] : history) {
        const Metric* metric = find(metrics, name);
        if (metric == nullptr || !metric->value || earlier.size() < kMinValues) continue;
        const BetterValue sense = better_value(name);
        if (sense == BetterValue::None) continue;
        std::vector<double> sizes;  // an error may have either sign
        sizes.reserve(earlier.size());
        for (const double value : earlier) sizes.push_back(std::abs(value));
        const double size = std::abs(*metric->value);
        const double middle = stats::median(sizes);
        std::vector<double> deviations;
        deviations.reserve(sizes.size());
        for (const double value : sizes) deviations.push_back(std::abs(value - middle));
        const double allowed = std::max(kSigmas * stats::kSigmasPerMad * stats::median(deviations),
                                        kTolerated * middle);
        const double sign = sense == BetterValue::Higher ? -1.0 : 1.0;
        if (sign * (size - middle) <= allowed) continue;
        regressions.push_back({{"figure", name},
                               {"value", size},
                               {"limit", middle + sign * allowed},
                               {"median", middle},
                               {"num_earlier", earlier.size()}});
    }
    return regressions;
}

}  // namespace divemesh::report
