#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "worker/stats/estimate.hpp"

namespace divemesh::compare {

// One entry of the figures of areas and labels.
struct ChangeMetric {
    std::string metric;
    std::string unit;
    std::string method;
    std::optional<stats::Estimate> earlier = {};
    std::optional<stats::Estimate> later = {};
};

nlohmann::json estimate_json(const stats::Estimate& estimate);

// `whose`: the names of what it is of (area, dive, label), which the entry begins with.
nlohmann::json change_json(nlohmann::json whose,
                           const ChangeMetric& metric,
                           const stats::Estimate& change);
nlohmann::json refused_change_json(nlohmann::json whose,
                                   const ChangeMetric& metric,
                                   const std::string& reason);

}  // namespace divemesh::compare
