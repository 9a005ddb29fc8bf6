#include "worker/report/report_reef.hpp"

#include "worker/base/text.hpp"
#include "worker/report/html_parts.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

std::string number_text(const json& value) {
    return value.is_number() ? base::significant(value.get<double>(), 5) : "";
}

std::string name_of(const json& metric) {
    std::string name = "reef.";
    name.append(metric.at("figure").get<std::string>());
    const auto add = [&](const std::string& part) { name.append("[").append(part).append("]"); };
    add(metric.at("area").get<std::string>());
    if (metric.contains("label")) add(metric["label"].get<std::string>());
    if (metric.contains("resolution_m")) add(number_text(metric["resolution_m"]));
    return name;
}

const json& list_of(const json& reef) {
    static const json kNone = json::array();
    return reef.is_null() ? kNone : reef.at("figures");
}

}  // namespace

std::vector<Metric> reef_metrics(const json& reef) {
    std::vector<Metric> metrics;
    for (const json& metric : list_of(reef)) {
        const std::string name = name_of(metric);
        const auto unit = metric.at("unit").get<std::string>();
        if (metric.contains("refused")) {
            metrics.push_back({name,
                               std::nullopt,
                               unit,
                               "refused: " + metric["refused"].get<std::string>(),
                               "none"});
            continue;
        }
        const auto method = metric.at("method").get<std::string>();
        metrics.push_back({name, metric.at("value").get<double>(), unit, method, "none"});
        for (const char* end : {"low", "high"})
            metrics.push_back({std::string(name).append(".").append(end),
                               metric.at(end).get<double>(),
                               unit,
                               "end of the 95 % interval; " + method,
                               "none"});
    }
    return metrics;
}

json reef_table(const json& reef) {
    std::vector<std::vector<std::string>> rows = {
        {"Area", "Metric", "Label", "At, m", "Value", "Unit", "95 % interval"}};
    for (const json& metric : list_of(reef)) {
        const bool is_refused = metric.contains("refused");
        rows.push_back(
            {metric.at("area"),
             metric.at("figure"),
             metric.value("label", ""),
             number_text(metric.value("resolution_m", json())),
             is_refused ? "refused" : number_text(metric.at("value")),
             metric.at("unit"),
             is_refused ? metric.at("refused").get<std::string>()
                        : number_text(metric.at("low")) + " to " + number_text(metric.at("high"))});
    }
    return grid_values(rows);
}

}  // namespace divemesh::report
