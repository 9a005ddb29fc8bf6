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

// The inputs of an accuracy report: the reconstruction and the known truth, where files of the
// request override those of the dive.
struct ReportInputs {
    io::ReconstructionFolder reconstruction;
    std::unique_ptr<dive::Dive> dive;         // null: not given
    std::optional<io::TrajectoryFile> truth;  // nullopt: no truth
    std::string truth_source;                 // "dive" or the name of the file
    std::optional<types::Mesh> reference;     // without triangles: a cloud
    std::optional<types::Mesh> scene;         // all true surface, of which the reference is a part
    std::vector<dive::KnownDistance> known_distances;
    nlohmann::json files;  // "files" of report.json
    std::vector<Finding> findings;
};

// Reads measurements.json; adds findings for faulty single distances. Throws Error{BadData} if the
// file is unreadable, Error{TooLarge} beyond 16 MiB.
std::vector<dive::KnownDistance> read_known_distances(const std::filesystem::path& file,
                                                      std::vector<Finding>& findings);

// Throws Error{BadData} if the dive is not that of the reconstruction.
ReportInputs read_report_inputs(const AccuracyReportRequest& request,
                                const base::ProgressCallback& progress);

}  // namespace divemesh::report
