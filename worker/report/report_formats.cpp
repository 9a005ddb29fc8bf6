#include "worker/report/report_formats.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

#include "schemas/json.hpp"
#include "worker/io/csv_cell.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

// Returns the shortest text that reads back as the same number.
std::string number_text(const json& value) {
    if (!value.is_number()) return "";
    std::array<char, 40> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value.get<double>()).ptr;
    return {text.data(), end};
}

// Leaves out characters that XML 1.0 does not allow.
std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '&': result += "&amp;"; break;
            case '<': result += "&lt;"; break;
            case '>': result += "&gt;"; break;
            case '"': result += "&quot;"; break;
            case '\n': result += "&#10;"; break;
            default:
                if (static_cast<unsigned char>(c) >= 0x20) result += c;
        }
    }
    return result;
}

std::string attribute(const char* name, const std::string& value) {
    return std::string(" ").append(name).append("=\"").append(escaped(value)).append("\"");
}

std::string test_case(const json& requirement) {
    std::string xml = "    <testcase" +
                      attribute("classname", requirement.at("figure").get<std::string>()) +
                      attribute("name", requirement.at("text").get<std::string>()) + " time=\"0\"";
    if (requirement.at("met").get<bool>()) return xml + "/>\n";
    const auto reason = requirement.at("reason").get<std::string>();
    return xml + ">\n      <failure" + attribute("type", "requirement") +
           attribute("message", reason) + ">" + escaped(reason) + "</failure>\n    </testcase>\n";
}

std::string property(const char* name, const std::string& value) {
    return "      <property" + attribute("name", name) + attribute("value", value) + "/>\n";
}

// Returns the verdict on the reconstruction; "" in documents of earlier versions.
std::string verdict_properties(const json& reconstruction) {
    if (!reconstruction.contains("verdict")) return "";
    std::string restricted;
    for (const json& part : reconstruction.at("restrictions"))
        restricted += (restricted.empty() ? "" : ", ") + part.get<std::string>();
    return "    <properties>\n" + property("verdict", reconstruction.at("verdict")) +
           property("restrictions", restricted) + "    </properties>\n";
}

// Returns the findings on the reconstruction, then those on its accuracy, a line each.
std::string system_out(const json& report) {
    std::string lines;
    for (const json& findings : {report.at("reconstruction").at("findings"), report.at("findings")})
        for (const Finding& finding : findings.get<std::vector<Finding>>())
            lines +=
                escaped(std::string(to_string(finding.severity)) + " " + finding.code + ": " +
                        (finding.where.empty() ? "" : finding.where + ": ") + finding.message) +
                "\n";
    return lines.empty() ? "" : "    <system-out>\n" + lines + "    </system-out>\n";
}

}  // namespace

std::string report_csv(const json& report) {
    std::string csv = "figure,value,unit,method,alignment\r\n";
    for (const json& metric : report.at("figures"))
        csv += io::csv_cell(metric.at("figure")) + "," + number_text(metric.at("value")) + "," +
               io::csv_cell(metric.at("unit")) + "," + io::csv_cell(metric.at("method")) + "," +
               io::csv_cell(metric.at("alignment")) + "\r\n";
    return csv;
}

std::string report_junit(const json& report) {
    const json& requirements = report.at("requirements");
    const auto num_unmet =
        std::count_if(requirements.begin(), requirements.end(), [](const json& requirement) {
            return !requirement.at("met").get<bool>();
        });
    const std::string counts = attribute("tests", std::to_string(requirements.size())) +
                               attribute("failures", std::to_string(num_unmet)) +
                               " errors=\"0\" skipped=\"0\" time=\"0\"";
    std::string name = report.at("dive").at("name");
    if (name.empty()) name = report.at("dive").at("content_sha256").get<std::string>();
    std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" + counts +
                      ">\n  <testsuite" + attribute("name", "divemesh accuracy " + name) + counts +
                      ">\n";
    xml += verdict_properties(report.at("reconstruction"));
    for (const json& requirement : requirements) xml += test_case(requirement);
    return xml + system_out(report) + "  </testsuite>\n</testsuites>\n";
}

}  // namespace divemesh::report
