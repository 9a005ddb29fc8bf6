#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/evaluation/surface_error.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/evaluation/truth_registration.hpp"
#include "worker/report/report_inputs.hpp"

namespace divemesh::report {

// New measurements, and what the page shows of them.
struct ReportMeasurements {
    nlohmann::json document;  // metrics.json with the sections that were measured again
    types::Trajectory path;   // final, its largest segment
    std::optional<evaluation::TrajectoryError> trajectory;
    bool has_orientation = true;  // of the truth
    std::optional<evaluation::SurfaceError> surface;
    std::string error_map_png;     // "": no map
    double error_map_end_m = 0.0;  // the distance of its last colour
    nlohmann::json reef;           // as measure_areas() returns it; null: no areas were given
    std::vector<Finding> findings;
};

// Measures what the inputs allow; a measurement that is not possible becomes a finding.
ReportMeasurements measure_for_report(const ReportInputs& inputs,
                                      const AccuracyReportRequest& request,
                                      const base::ProgressCallback& progress);

}  // namespace divemesh::report
