#include "worker/report/report.hpp"

#include "schemas/base64.hpp"
#include "worker/report/html_template.hpp"
#include "worker/report/html_templates.hpp"
#include "worker/report/metric_rows.hpp"
#include "worker/report/path_plots.hpp"

namespace divemesh::report {

using nlohmann::json;

std::string report_html(const ReportInput& input) {
    const auto text = [&](const char* pointer) {
        return input.metrics.value(json::json_pointer(pointer), std::string());
    };
    const std::string name = text("/dive/name");
    const auto& trajectory = input.evaluation.trajectory;
    const evaluation::TrajectoryError* error = trajectory ? &*trajectory : nullptr;
    json image;
    if (!input.image_png.empty()) image = {{"png", encode_base64(input.image_png)}};
    return fill_template(
        reconstruction_page_html(),
        {{"title", name.empty() ? "dive " + text("/dive/content_sha256").substr(0, 12) : name},
         {"version", text("/version")},
         {"preset", text("/preset")},
         {"verdict", verdict_values(input.metrics)},
         {"image", image},
         {"accuracy", rows_values(accuracy_rows(input.metrics))},
         {"expected", rows_values(expected_rows(input.metrics))},
         {"path_from_above", svg_plot(path_from_above(error, input.trajectory))},
         {"error_over_time", svg_plot(error_over_time(error, input.trajectory))},
         {"dive", rows_values(dive_rows(input.metrics))},
         {"result", rows_values(result_rows(input.metrics))},
         {"findings", findings_values(input.metrics.value("findings", json::array()))}});
}

}  // namespace divemesh::report
