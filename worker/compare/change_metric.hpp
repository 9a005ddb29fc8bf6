#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "worker/stats/estimate.hpp"

namespace divemesh::compare {

// One metric of an area or a label.
struct ChangeMetric {
    std::string metric;
    std::string unit;
    std::string method;
    std::optional<stats::Estimate> earlier = {};
    std::optional<stats::Estimate> later = {};
};

// Returns {value, low, high}.
nlohmann::json estimate_json(const stats::Estimate& estimate);

// Return an entry of "figures". It begins with `whose`, the names of its area, dive and label.
nlohmann::json change_json(nlohmann::json whose,
                           const ChangeMetric& metric,
                           const stats::Estimate& change);
nlohmann::json refused_change_json(nlohmann::json whose,
                                   const ChangeMetric& metric,
                                   const std::string& reason);

}  // namespace divemesh::compare
