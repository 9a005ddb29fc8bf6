#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// A number that a report can quote. The name is its way through metrics.json and what the report
// adds, "trajectory.final.ate_rmse_m"; entries of lists by what tells them apart,
// "trajectory.final.segments[2].translation_mean_percent".
struct Metric {
    std::string name;
    std::optional<double> value;  // nothing: asked for and not to be had
    std::string unit;             // SI as in the name; "1": none
    std::string method;           // as the schema describes it
    std::string alignment;        // what was laid on what before it was taken
};

// Every number of the document, in the order of its keys. Method and unit come from
// metrics.schema.json and report.schema.json.
std::vector<Metric> flatten_metrics(const nlohmann::json& document);

// The full name for what a person writes: the whole name or the end of it ("drift_percent",
// "accuracy.median_m"). Of several, that of the final trajectory goes first, then the shortest
// way. Throws Error{InvalidArgument} that lists similar names, or those it could mean.
std::string resolve_metric(std::string_view text);

// The names of all figures that the schemas describe; [*] stands for any entry of a list.
std::vector<std::string> known_metric_names();

}  // namespace divemesh
