#include "worker/report/html_parts.hpp"

#include "worker/report/html_templates.hpp"

namespace divemesh::report {

using nlohmann::json;

const std::map<std::string, std::string_view>& html_parts() {
    static const std::map<std::string, std::string_view> kParts = {
        {"accuracy_rows", accuracy_rows_html()},
        {"dive_rows", dive_rows_html()},
        {"findings", findings_html()},
        {"grid", grid_html()},
        {"page_head", page_head_html()},
        {"rows", rows_html()}};
    return kParts;
}

json rows_values(const HtmlRows& rows) {
    if (rows.empty()) return nullptr;
    json list = json::array();
    for (const auto& [name, value] : rows) list.push_back({{"name", name}, {"value", value}});
    return {{"rows", list}};
}

json grid_values(const std::vector<std::vector<std::string>>& rows) {
    if (rows.size() < 2) return nullptr;
    return {{"head", rows.front()},
            {"body", std::vector<std::vector<std::string>>(rows.begin() + 1, rows.end())}};
}

json verdict_values(const json& judged) {
    const std::string verdict = judged.value("verdict", std::string());
    if (verdict.empty()) return nullptr;
    if (verdict == "good") return {{"class", "met"}, {"text", "Good"}};
    std::string text = verdict == "not_usable" ? "Not usable" : "Usable with restrictions";
    const char* separator = ": ";
    for (const json& restricted : judged.value("restrictions", json::array())) {
        if (restricted == "all") continue;
        text += separator + restricted.get<std::string>();
        separator = ", ";
    }
    return {{"class", verdict == "not_usable" ? "error" : "warning"}, {"text", text}};
}

json findings_values(const json& findings) {
    if (findings.empty()) return nullptr;
    json list = json::array();
    for (const json& finding : findings) {
        json shown;
        for (const char* key : {"severity", "where", "message", "remedy"})
            shown[key] = finding.value(key, std::string());
        list.push_back(std::move(shown));
    }
    return {{"list", list}};
}

}  // namespace divemesh::report
