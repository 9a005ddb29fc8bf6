#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "worker/evaluation/evaluation.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::report {

struct ReportInput {
    const nlohmann::json& metrics;        // metrics.json
    const types::Trajectory& trajectory;  // final
    const evaluation::Evaluation& evaluation;
    std::string image_png;  // of the result, at most some 100 kB; "" for none
};

// report.html: one self-contained page for a person. Figures, two plots, the picture, the
// findings; whatever came from the dive is escaped, no script, nothing is loaded.
std::string report_html(const ReportInput& input);

}  // namespace divemesh::report
