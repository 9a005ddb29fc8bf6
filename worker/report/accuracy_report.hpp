#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "schemas/truth_options.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::report {

struct AccuracyReportRequest {
    std::filesystem::path reconstruction;       // see ReconstructionFolder
    std::optional<std::filesystem::path> dive;  // folder or archive: its rig, and its own truth
    std::filesystem::path out;                  // made when missing
    std::filesystem::path scratch;              // the caller removes it
    // Each goes before what the dive brings.
    std::optional<std::filesystem::path> ground_truth;  // TUM, EuRoC or KITTI
    std::optional<std::filesystem::path> reference;     // PLY, OBJ or GLB; mesh or points
    std::optional<std::filesystem::path> measurements;  // measurements.json; needs the dive
    std::optional<std::filesystem::path> areas;         // areas.json: polygons, for reef figures
    TruthOptions truth;                                 // of `ground_truth`
    std::vector<std::string> requirements;              // see schemas/requirement.hpp
    // Earlier values of figures, oldest first, by their full names.
    std::map<std::string, std::vector<double>> history;
    std::vector<Finding> findings;  // of what it is made of: told in it
    int num_threads = 0;            // 0: all cores; never changes a figure
};

// Measures a reconstruction against what is known and writes report.json
// (schemas/report.schema.json), report.csv, report.html and junit.xml into `out`; returns what
// report.json holds. A truth that does not fit is a finding in it, and the figures that it would
// have given are not there. Throws Error{InvalidArgument} for a requirement or option that is
// wrong, Error{NotFound} and Error{BadData} for a file that is not there or cannot be read,
// Error{Cancelled}.
nlohmann::json make_accuracy_report(const AccuracyReportRequest& request,
                                    const base::ProgressCallback& progress);

}  // namespace divemesh::report
