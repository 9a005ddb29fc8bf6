#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "worker/dive/dive.hpp"
#include "worker/markers/measure_bars.hpp"
#include "worker/markers/world_scale.hpp"
#include "worker/metrics/evaluation.hpp"
#include "worker/metrics/metrics_document.hpp"
#include "worker/optimised_track.hpp"
#include "worker/reconstruct_dive.hpp"
#include "worker/surface.hpp"
#include "worker/track.hpp"
#include "worker/volume/mesh_borders.hpp"

namespace divemesh::worker {

// What a run over a dive made, which figures are taken of.
struct Reconstruction {
    const ReconstructionRequest& request;
    const Dive& dive;
    const Track& track;
    std::int64_t num_landmarks = 0;
    const OptimisedTrack& optimised;
    const Surface& surface;  // empty without options.surface, as is what follows up to the memory
    const MeshBorders& borders;
    const CloudFigures& cloud;
    double voxel_m = 0.0;
    std::int64_t volume_memory_bytes = 0;
    const std::optional<WorldScale>& scale;       // that was applied
    const std::optional<MarkerFigures>& markers;  // nothing: nobody asked for them
    const std::vector<StageTime>& stages;
};

// With what the dive itself knows better: its true trajectory, reference surface and distances.
Evaluation compare_with_truth(const Reconstruction& made);

// metrics.json.
nlohmann::json metrics_of(const Reconstruction& made, const Evaluation& evaluation);

}  // namespace divemesh::worker
