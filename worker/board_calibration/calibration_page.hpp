#pragma once

#include <string>
#include <string_view>

#include "worker/board_calibration/calibration_document.hpp"

namespace divemesh::board_calibration {

// Returns the template of the page, for report::fill_template().
std::string_view calibration_page_html();

// Returns report.html: verdict, findings, coverage and residuals of a calibration in one file.
// `document` is what calibration_document() returns.
std::string calibration_page(const RigEstimate& estimate, const nlohmann::json& document);

}  // namespace divemesh::board_calibration
