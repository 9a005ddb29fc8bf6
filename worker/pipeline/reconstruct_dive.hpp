#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "schemas/job.hpp"
#include "schemas/links.hpp"
#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::pipeline {

struct Reconstruction;
template <typename State>
struct Stage;
class StageStore;

// A request to reconstruct one dive.
struct ReconstructionRequest {
    std::filesystem::path dive;     // folder, archive or recording
    std::filesystem::path out;      // for the artifacts, under their API names; created if missing
    std::filesystem::path scratch;  // for files between stages; the caller removes it
    std::filesystem::path cache = {};  // the stage store; empty: no store
    std::int64_t cache_bytes = 0;
    // Whether each stage leaves in `scratch` what another run needs to continue after it, i.e. a
    // copy of the map and the mesh.
    bool resumable = true;
    std::string preset = "standard";
    ReconstructionOptions options;
    std::function<void(const StageRun&)> stage_done = [](const StageRun&) {};
    // Called with the findings on the dive before it is reconstructed or refused.
    std::function<void(const std::vector<Finding>&)> dive_checked =
        [](const std::vector<Finding>&) {};
    Links links = Links::LeaveOut;  // in the folder `dive`
};

// Reconstructs a dive: opens it, runs the table of stages (reconstruction_stages.hpp), and writes
// trajectory, cloud, mesh, mosaic, heights, keyframes, metrics.json and report.html; with
// options.surface false only what follows from the trajectory. Returns the content of metrics.json.
// If no usable model results, the verdict states it, the findings give the reason, and the results
// so far are written. Throws Error{BadData} with the first error among the findings on the dive,
// Error{Cancelled}, Error{OutOfSpace}.
nlohmann::json reconstruct_dive(const ReconstructionRequest& request,
                                const base::ProgressCallback& progress);

// The same with other stages and another store instead of the folder request.cache.
nlohmann::json reconstruct_dive(const ReconstructionRequest& request,
                                const std::vector<Stage<Reconstruction>>& stages,
                                StageStore& store,
                                const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
