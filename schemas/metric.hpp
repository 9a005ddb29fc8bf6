#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// A number that a report can quote. The name is its path in metrics.json and in what the report
// adds, e.g. "trajectory.final.ate_rmse_m". Entries of lists are named by what distinguishes them,
// e.g. "trajectory.final.segments[2].translation_mean_percent".
struct Metric {
    std::string name;
    std::optional<double> value;  // nullopt: computed but not available
    std::string unit;             // SI as in the name; "1": dimensionless
    std::string method;           // as the schema describes it
    std::string alignment;        // which alignment preceded it
};

// Returns every number of the document, in the order of its keys. Method and unit come from
// metrics.schema.json and report.schema.json.
std::vector<Metric> flatten_metrics(const nlohmann::json& document);

// Returns the full name for what a user writes: the whole name or its end ("drift_percent",
// "accuracy.median_m"). Of several matches the final trajectory's comes first, then the shortest
// path. Throws Error{InvalidArgument}, which lists similar names, or the ambiguous ones.
std::string resolve_metric(std::string_view text);

// Returns the names of all metrics that the schemas describe; [*] stands for any entry of a list.
std::vector<std::string> known_metric_names();

}  // namespace divemesh
