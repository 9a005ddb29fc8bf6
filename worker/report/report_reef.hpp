#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "schemas/metric.hpp"

namespace divemesh::report {

// What measure_areas() answers as figures of a report: "reef.rugosity[quadrat 1][0.05]" by area,
// label where there is one, and resolution in m, its interval as ".low" and ".high". One that is
// refused has no value, and its method says why. Of null: none.
std::vector<Metric> reef_metrics(const nlohmann::json& reef);

// The same for {{>grid}} of the page; null of null.
nlohmann::json reef_table(const nlohmann::json& reef);

}  // namespace divemesh::report
