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
    double full_change_m = 0.0;  // the change of full colour
};

// report.html of a comparison: one self-contained page. Pictures of both years and of what changed,
// figures with their intervals, the patches, how the two were laid over each other. Texts that came
// from dives are escaped, no script, nothing is loaded.
std::string compare_report(const CompareReportInput& input);

}  // namespace divemesh::compare
