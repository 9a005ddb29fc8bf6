#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "schemas/links.hpp"
#include "schemas/truth_options.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::report {

struct AccuracyReportRequest {
    std::filesystem::path reconstruction;       // see ReconstructionFolder
    std::optional<std::filesystem::path> dive;  // folder or archive, with its rig and its own truth
    Links links = Links::LeaveOut;              // in the folder
    std::filesystem::path out;                  // created if missing
    std::filesystem::path scratch;              // the caller removes it
    // These override what the dive contains.
    std::optional<std::filesystem::path> ground_truth;  // TUM, EuRoC or KITTI
    std::optional<std::filesystem::path> reference;     // PLY, OBJ or GLB; mesh or points
    std::optional<std::filesystem::path> measurements;  // measurements.json; needs the dive
    std::optional<std::filesystem::path> areas;         // areas.json: polygons, for reef metrics
    TruthOptions truth;                                 // of `ground_truth`
    std::vector<std::string> requirements;              // see schemas/requirement.hpp
    // Earlier values of metrics, oldest first, by their full names.
    std::map<std::string, std::vector<double>> history;
    std::vector<Finding> findings;  // findings of the inputs, which the report includes
    std::int64_t num_surface_samples = 1'000'000;  // in each direction
    int num_threads = 0;                           // 0: all cores; never changes a result
};

// Compares a reconstruction with the known truth and writes report.json
// (schemas/report.schema.json), report.csv, report.html and junit.xml into `out`; returns the
// content of report.json. It repeats the verdict and the findings of the reconstruction; no
// requirement on one that is not usable is met. A truth that does not fit is a finding, and its
// metrics are missing. Throws Error{InvalidArgument} for a wrong requirement or option,
// Error{NotFound} and Error{BadData} for a missing or unreadable file, Error{Cancelled}.
nlohmann::json make_accuracy_report(const AccuracyReportRequest& request,
                                    const base::ProgressCallback& progress);

}  // namespace divemesh::report
