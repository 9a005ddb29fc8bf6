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
    std::string image_png;  // of the result, at most about 100 kB; "": no image
};

// Returns report.html: one self-contained page with metrics, two plots, the image and the findings.
// All text from the dive is escaped; there are no scripts and no external resources.
std::string report_html(const ReportInput& input);

}  // namespace divemesh::report
