#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "schemas/job.hpp"
#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::pipeline {

struct Reconstruction;
template <typename State>
struct Stage;
class StageStore;

struct ReconstructionRequest {
    std::filesystem::path dive;  // folder or archive
    std::filesystem::path out;   // the artifacts, by the names of the contract; made when missing
    std::filesystem::path scratch;     // what the stages hand on; the caller removes it
    std::filesystem::path cache = {};  // the store of what stages made; empty: none is kept
    std::int64_t cache_bytes = 0;
    // Whether each stage leaves in `scratch` what another run there would need to go on after it;
    // it is a copy of the map and the mesh.
    bool resumable = true;
    std::string preset = "standard";
    ReconstructionOptions options;
    std::function<void(const StageRun&)> stage_done = [](const StageRun&) {};
};

// A dive goes in, the artifacts come out: opens it, runs the table of stages
// (reconstruction_stages.hpp), and writes trajectory, cloud, mesh, mosaic, keyframes, metrics.json
// and report.html; with options.surface false only what follows from the trajectory. Returns what
// metrics.json holds. Throws Error{BadData} with the first error among the findings,
// Error{Cancelled}, Error{OutOfSpace}.
nlohmann::json reconstruct_dive(const ReconstructionRequest& request,
                                const base::ProgressCallback& progress);

// The same with other stages and another store than the folder request.cache.
nlohmann::json reconstruct_dive(const ReconstructionRequest& request,
                                const std::vector<Stage<Reconstruction>>& stages,
                                StageStore& store,
                                const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
