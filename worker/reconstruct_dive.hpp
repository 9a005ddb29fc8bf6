#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "schemas/job.hpp"
#include "schemas/reconstruction_options.hpp"
#include "worker/observer.hpp"

namespace divemesh::worker {

struct ReconstructionRequest {
    std::filesystem::path dive;  // folder or archive
    std::filesystem::path out;   // the artifacts, by the names of the contract; made when missing
    std::filesystem::path scratch;     // what the stages hand on; the caller removes it
    std::filesystem::path cache = {};  // of what stages made; empty: none is kept
    std::int64_t cache_bytes = 0;
    // Whether each stage leaves in `scratch` what another run there would need to go on after it;
    // it is a copy of the map and the mesh.
    bool resumable = true;
    std::string preset = "standard";
    ReconstructionOptions options;
    std::function<void(const StageRun&)> stage_done = [](const StageRun&) {};
};

// A dive goes in, the artifacts come out: opens it, runs the stages track, optimise, fuse, mesh,
// texture, evaluate, and writes trajectory, cloud, mesh, mosaic, keyframes, metrics.json and
// report.html; with options.surface false only track, optimise and evaluate, and what they write.
// Returns what metrics.json holds. Throws Error{BadData} with the first error among the findings,
// Error{Cancelled}, Error{OutOfSpace}.
nlohmann::json reconstruct_dive(const ReconstructionRequest& request,
                                const ProgressCallback& progress);

}  // namespace divemesh::worker
