#pragma once

#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>
#include <string>

namespace divemesh::compare {

struct CompareReportInput {
    const nlohmann::json& document;  // compare.json
    cv::Mat surface_a;               // BGR, from above, on one grid
    cv::Mat surface_b;
    cv::Mat difference;
    double full_change_m = 0.0;  // the change that gets full colour
};

// Returns report.html of a comparison: one self-contained page with images of both years and of the
// change, metrics with their intervals, the patches, and the alignment of the two dives. All text
// from dives is escaped; there are no scripts and no external resources.
std::string compare_report(const CompareReportInput& input);

}  // namespace divemesh::compare
