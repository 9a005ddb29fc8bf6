#include "worker/compare/change_metric.hpp"

namespace divemesh::compare {
namespace {

nlohmann::json entry(nlohmann::json whose, const ChangeMetric& metric) {
    whose["figure"] = metric.metric;
    whose["unit"] = metric.unit;
    if (metric.earlier) whose["earlier"] = estimate_json(*metric.earlier);
    if (metric.later) whose["later"] = estimate_json(*metric.later);
    return whose;
}

}  // namespace

nlohmann::json estimate_json(const stats::Estimate& estimate) {
    return {{"value", estimate.value}, {"low", estimate.low}, {"high", estimate.high}};
}

nlohmann::json change_json(nlohmann::json whose,
                           const ChangeMetric& metric,
                           const stats::Estimate& change) {
    nlohmann::json json = entry(std::move(whose), metric);
    json["change"] = estimate_json(change);
    json["method"] = metric.method;
    return json;
}

nlohmann::json refused_change_json(nlohmann::json whose,
                                   const ChangeMetric& metric,
                                   const std::string& reason) {
    nlohmann::json json = entry(std::move(whose), metric);
    json["refused"] = reason;
    return json;
}

}  // namespace divemesh::compare
