#include "worker/board_calibration/calibration_page.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/text.hpp"
#include "worker/report/html_parts.hpp"
#include "worker/report/html_template.hpp"

namespace divemesh::board_calibration {
namespace {

using nlohmann::json;
using Grid = std::vector<std::vector<std::string>>;

constexpr double kCell = 20.0;            // width of a cell in the drawing
constexpr std::size_t kMaxPoints = 3000;  // more make one blot
constexpr double kLimitSigmas = 5.0;      // of the axes of residuals

std::string text_of(const json& value, int places) {
    return value.is_number() ? base::fixed(value.get<double>(), places) : "-";
}

std::string percent(const json& value) {
    return value.is_number() ? base::significant(100.0 * value.get<double>(), 2) + " %" : "-";
}

json cells(const json& camera, double height) {
    int most = 1;
    for (const json& row : camera.at("coverage_cells"))
        for (const json& num : row) most = std::max(most, num.get<int>());
    json list = json::array();
    for (std::size_t row = 0; row < kCoverageRows; ++row)
        for (std::size_t column = 0; column < kCoverageColumns; ++column) {
            const double num = camera.at("coverage_cells")[row][column].get<double>();
            const double opacity = num > 0.0 ? 0.15 + 0.85 * std::sqrt(num / most) : 0.0;
            list.push_back({{"x", base::fixed(kCell * static_cast<double>(column), 1)},
                            {"y", base::fixed(height * static_cast<double>(row), 1)},
                            {"cell_width", base::fixed(kCell, 1)},
                            {"cell_height", base::fixed(height, 1)},
                            {"opacity", base::fixed(opacity, 2)}});
        }
    return list;
}

json points(const RigEstimate& estimate, bool is_right, double limit_px) {
    json list = json::array();
    const std::size_t step = 1 + estimate.errors.size() / (2 * kMaxPoints);
    for (std::size_t i = 0; i < estimate.errors.size(); i += step) {
        const CornerError& error = estimate.errors[i];
        if (error.is_right != is_right || error.error_px.cwiseAbs().maxCoeff() > limit_px) continue;
        list.push_back({{"x", base::fixed(100.0 * error.error_px.x() / limit_px, 1)},
                        {"y", base::fixed(100.0 * error.error_px.y() / limit_px, 1)}});
    }
    return list;
}

json plots(const RigEstimate& estimate, const json& document) {
    const double limit_px = std::max(0.01, kLimitSigmas * estimate.sigma_px);
    json list = json::array();
    for (const bool is_right : {false, true}) {
        const char* name = is_right ? "cam1" : "cam0";
        const json& camera = document.at("cameras").at(name);
        const double height = kCell * kCoverageColumns / kCoverageRows *
                              camera.at("height_px").get<double>() /
                              camera.at("width_px").get<double>();
        list.push_back({{"camera", name},
                        {"width", base::fixed(kCell * kCoverageColumns, 1)},
                        {"height", base::fixed(height * kCoverageRows, 1)},
                        {"cells", cells(camera, height)},
                        {"limit", base::significant(limit_px, 2)},
                        {"points", points(estimate, is_right, limit_px)}});
    }
    return list;
}

json result(const RigEstimate& estimate, const json& document) {
    Grid lengths = {{"distance", "middle of the image", "near its border"}};
    for (const json& row : document.at("length_errors"))
        lengths.push_back({text_of(row.at("distance_m"), 0) + " m",
                           percent(row.at("center_sigma")),
                           percent(row.at("border_sigma"))});
    Grid parameters = {{"parameter", "value", "standard deviation"}};
    for (const json& row : document.at("parameters"))
        parameters.push_back({row.at("name").get<std::string>(),
                              base::significant(row.at("value").get<double>(), 7),
                              base::significant(row.at("sigma").get<double>(), 2)});
    Grid pairs = {{"time, ns", "corners cam0", "corners cam1", "RMS cam0, px", "RMS cam1, px"}};
    for (const json& row : document.at("pairs"))
        pairs.push_back({row.at("timestamp_ns").dump(),
                         row.at("num_corners_cam0").dump(),
                         row.at("num_corners_cam1").dump(),
                         text_of(row.at("rms_cam0_px"), 3),
                         text_of(row.at("rms_cam1_px"), 3)});
    return {{"plots", plots(estimate, document)},
            {"lengths", report::grid_values(lengths)},
            {"parameters", report::grid_values(parameters)},
            {"pairs", report::grid_values(pairs)}};
}

}  // namespace

std::string calibration_page(const RigEstimate& estimate, const json& document) {
    json values = {{"title", "Calibration with a board"},
                   {"verdict", document.at("verdict")},
                   {"class", document.at("usable").get<bool>() ? "met" : "unmet"},
                   {"findings", report::findings_values(document.at("findings"))},
                   {"result", nullptr}};
    if (estimate.failure.empty()) values["result"] = result(estimate, document);
    return report::fill_template(calibration_page_html(), values);
}

}  // namespace divemesh::board_calibration
