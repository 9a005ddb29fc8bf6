#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "worker/base/observer.hpp"

namespace divemesh::compare {

struct CompareOptions {
    double cell_m = 0.0;          // of the maps; 0: the meshes' mean edge, 5 mm at least
    double normal_scale_m = 0.0;  // over which the ground's direction is taken; 0: 8 cells
    double cylinder_m = 0.0;      // diameter over which places are averaged; 0: 4 cells
    double reach_m = 0.6;         // larger changes are measured along the vertical alone
    double least_area_m2 = 0.0;   // of a patch; 0: four sections of the cylinder
};

struct CompareRequest {
    std::filesystem::path a;    // folder of the earlier reconstruction
    std::filesystem::path b;    // of the later one
    std::filesystem::path out;  // made when missing
    // areas.json, each in the frame of the reconstruction that it is drawn on; without the later,
    // the earlier stand for the place.
    std::optional<std::filesystem::path> areas;
    std::optional<std::filesystem::path> later_areas;
    CompareOptions options;
    int num_threads = 0;  // 0: as many as there are cores; never changes a byte
    std::uint64_t seed = 1;
};

// What changed between two dives of one place. Lays b over a (markers, features or geometry, then
// stable surface), measures M3C2 distances with their level of detection, and gathers significant
// change that both dives could see into patches with volumes and 95 % intervals. Writes
// compare.json (schemas/compare.schema.json), report.html, changed_mesh.ply (b coloured by change,
// with the distances), mosaic_difference.png and .json, change_height.png, and with areas
// area_changes.csv into `out` and returns compare.json. The same request gives the same bytes
// whatever the number of threads. Stages of the progress: register, measure, change, write. Throws
// Error{NotFound} or Error{BadData} for folders that are no reconstructions with a surface,
// Error{Conflict} when the two cannot be laid over each other (different places, too little
// overlap, ambiguous ground), Error{InvalidArgument} for options out of range.
nlohmann::json compare_reconstructions(
    const CompareRequest& request, const base::ProgressCallback& report = base::ignore_progress);

}  // namespace divemesh::compare
