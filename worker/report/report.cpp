#include "worker/report/report.hpp"

#include "worker/report/figure_rows.hpp"
#include "worker/report/html_parts.hpp"
#include "worker/report/path_plots.hpp"

namespace divemesh::worker {

using nlohmann::json;

std::string report_html(const ReportInput& input) {
    const auto text = [&](const char* pointer) {
        return input.metrics.value(json::json_pointer(pointer), std::string());
    };
    std::string name = text("/dive/name");
    if (name.empty()) name = "dive " + text("/dive/content_sha256").substr(0, 12);
    const auto& trajectory = input.evaluation.trajectory;
    const TrajectoryError* error = trajectory ? &*trajectory : nullptr;
    std::string html = html_head(name) + "<body><h1>" + escape_html(name) +
                       "</h1><p class=\"sub\">divemesh " + escape_html(text("/version")) +
                       ", preset " + escape_html(text("/preset")) + "</p><div class=\"row\">";
    if (!input.picture_png.empty())
        html += "<section><h2>From above</h2>" +
                html_picture(input.picture_png, "The mesh from above") + "</section>";
    html += html_table("Against the truth", accuracy_rows(input.metrics)) +
            html_table("Expected, without truth", expected_rows(input.metrics)) +
            "</div><div class=\"row\">" + svg_plot(path_from_above(error, input.trajectory)) +
            svg_plot(error_over_time(error, input.trajectory)) + "</div><div class=\"row\">" +
            html_table("The dive", dive_rows(input.metrics)) +
            html_table("The result", result_rows(input.metrics)) + "</div><h2>Findings</h2>" +
            html_findings(input.metrics.value("findings", json::array())) + "</body></html>\n";
    return html;
}

}  // namespace divemesh::worker
