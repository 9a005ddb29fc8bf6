#include "cli/report_text.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <vector>

#include "cli/findings_text.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"

namespace divemesh::cli {
namespace {

std::string value_text(const nlohmann::json& value) {
    if (!value.is_number()) return "-";
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", value.get<double>());
    return text;
}

std::string unit_text(const nlohmann::json& metric) {
    const auto unit = metric.at("unit").get<std::string>();
    return unit == "1" || !metric.at("value").is_number() ? "" : " " + unit;
}

// Adds lever arm and time offset if they were solved.
void add_truth(const nlohmann::json& report, std::vector<std::vector<std::string>>& rows) {
    const nlohmann::json truth = report.value("truth", nlohmann::json::object());
    if (!truth.contains("num_poses")) return;
    const auto& offset = truth.at("time_offset_s");
    const auto& lever = truth.at("lever_arm_m");
    if (offset.contains("sigma"))
        rows.push_back({"",
                        "time offset of the truth",
                        value_text(offset.at("value")) + " s, sigma " +
                            value_text(offset.at("sigma")) + " s"});
    if (lever.contains("sigma"))
        for (std::size_t axis = 0; axis < 3; ++axis)
            rows.push_back({"",
                            std::string("lever arm of the truth, ") + "xyz"[axis],
                            value_text(lever.at("vector").at(axis)) + " m, sigma " +
                                value_text(lever.at("sigma").at(axis)) + " m"});
}

// Returns what the report says of the reconstruction; reports of older versions say less.
nlohmann::json reconstruction_of(const nlohmann::json& report) {
    return report.value("reconstruction", nlohmann::json::object());
}

void add_verdict(const nlohmann::json& reconstruction,
                 std::vector<std::vector<std::string>>& rows) {
    if (!reconstruction.contains("verdict")) return;
    rows.push_back({"",
                    "verdict on the reconstruction",
                    verdict_words(reconstruction.at("verdict").get<std::string>(),
                                  reconstruction.at("restrictions"))});
}

}  // namespace

std::string report_summary(const nlohmann::json& report) {
    constexpr const char* kQuoted[] = {"trajectory.final.ate_rmse_m",
                                       "trajectory.final.drift_percent",
                                       "surface.accuracy.median_m",
                                       "surface.completeness.median_m",
                                       "known_distances.scale_error"};
    std::vector<std::vector<std::string>> rows;
    add_verdict(reconstruction_of(report), rows);
    for (const auto& requirement : report.at("requirements"))
        rows.push_back({requirement.at("met").get<bool>() ? "met" : "NOT MET",
                        requirement.at("text").get<std::string>(),
                        requirement.at("reason").get<std::string>()});
    for (const auto& regression : report.at("regressions"))
        rows.push_back({"WORSE",
                        regression.at("figure").get<std::string>(),
                        value_text(regression.at("value")) + ", limit from its history " +
                            value_text(regression.at("limit"))});
    for (const auto& metric : report.at("figures"))
        if (std::find(std::begin(kQuoted),
                      std::end(kQuoted),
                      metric.at("figure").get<std::string>()) != std::end(kQuoted))
            rows.push_back({"",
                            metric.at("figure").get<std::string>(),
                            value_text(metric.at("value")) + unit_text(metric)});
    add_truth(report, rows);
    return table_text(rows);
}

std::string report_findings(const nlohmann::json& report) {
    std::string text;
    for (const nlohmann::json& findings :
         {reconstruction_of(report).value("findings", nlohmann::json::array()),
          report.at("findings")})
        for (const Finding& finding : findings.get<std::vector<Finding>>())
            text += finding_text(finding);
    return text;
}

}  // namespace divemesh::cli
