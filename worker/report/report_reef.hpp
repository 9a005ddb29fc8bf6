#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "schemas/metric.hpp"

namespace divemesh::report {

// Returns the result of measure_areas() as metrics of a report: "reef.rugosity[quadrat 1][0.05]" by
// area, label if there is one, and resolution in m, with its interval as ".low" and ".high". A
// refused metric has no value, and its method says why. Null gives an empty list.
std::vector<Metric> reef_metrics(const nlohmann::json& reef);

// Returns the same for {{>grid}} of the page; null for null.
nlohmann::json reef_table(const nlohmann::json& reef);

}  // namespace divemesh::report
