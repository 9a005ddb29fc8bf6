#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/dive/dive.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/report/accuracy_report.hpp"

namespace divemesh::report {

// What an accuracy report is made of: the reconstruction, and whatever is known from elsewhere,
// files of the request before what the dive brings.
struct ReportInputs {
    io::ReconstructionFolder reconstruction;
    std::unique_ptr<dive::Dive> dive;         // none: not given
    std::optional<io::TrajectoryFile> truth;  // nothing: none
    std::string truth_source;                 // "dive" or the name of the file
    std::optional<types::Mesh> reference;     // without triangles: a cloud
    std::vector<dive::KnownDistance> known_distances;
    nlohmann::json files;  // "files" of report.json
    std::vector<Finding> findings;
};

// measurements.json; adds what is wrong with single distances. Throws Error{BadData} when nothing
// of it can be read, Error{TooLarge} beyond 16 MiB.
std::vector<dive::KnownDistance> read_known_distances(const std::filesystem::path& file,
                                                      std::vector<Finding>& findings);

// Throws Error{BadData} when the dive is another one than that of the reconstruction.
ReportInputs read_report_inputs(const AccuracyReportRequest& request,
                                const base::ProgressCallback& progress);

}  // namespace divemesh::report
