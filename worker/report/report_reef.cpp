#include "worker/report/report_reef.hpp"

#include <cstdio>

#include "worker/report/html_parts.hpp"

namespace divemesh::worker {
namespace {

using nlohmann::json;

std::string number_text(const json& value) {
    if (!value.is_number()) return "";
    char text[40];
    std::snprintf(text, sizeof text, "%.5g", value.get<double>());
    return text;
}

std::string name_of(const json& figure) {
    std::string name = "reef.";
    name.append(figure.at("figure").get<std::string>());
    const auto add = [&](const std::string& part) { name.append("[").append(part).append("]"); };
    add(figure.at("area").get<std::string>());
    if (figure.contains("label")) add(figure["label"].get<std::string>());
    if (figure.contains("resolution_m")) add(number_text(figure["resolution_m"]));
    return name;
}

const json& list_of(const json& reef) {
    static const json kNone = json::array();
    return reef.is_null() ? kNone : reef.at("figures");
}

}  // namespace

std::vector<Figure> reef_figures(const json& reef) {
    std::vector<Figure> figures;
    for (const json& figure : list_of(reef)) {
        const std::string name = name_of(figure);
        const auto unit = figure.at("unit").get<std::string>();
        if (figure.contains("refused")) {
            figures.push_back({name,
                               std::nullopt,
                               unit,
                               "refused: " + figure["refused"].get<std::string>(),
                               "none"});
            continue;
        }
        const auto method = figure.at("method").get<std::string>();
        figures.push_back({name, figure.at("value").get<double>(), unit, method, "none"});
        for (const char* end : {"low", "high"})
            figures.push_back({std::string(name).append(".").append(end),
                               figure.at(end).get<double>(),
                               unit,
                               "end of the 95 % interval; " + method,
                               "none"});
    }
    return figures;
}

json reef_table(const json& reef) {
    std::vector<std::vector<std::string>> rows = {
        {"Area", "Figure", "Label", "At, m", "Value", "Unit", "95 % interval"}};
    for (const json& figure : list_of(reef)) {
        const bool is_refused = figure.contains("refused");
        rows.push_back(
            {figure.at("area"),
             figure.at("figure"),
             figure.value("label", ""),
             number_text(figure.value("resolution_m", json())),
             is_refused ? "refused" : number_text(figure.at("value")),
             figure.at("unit"),
             is_refused ? figure.at("refused").get<std::string>()
                        : number_text(figure.at("low")) + " to " + number_text(figure.at("high"))});
    }
    return grid_values(rows);
}

}  // namespace divemesh::worker
