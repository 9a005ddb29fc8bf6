#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "worker/base/observer.hpp"

namespace divemesh::compare {

struct CompareOptions {
    double cell_m = 0.0;          // of the maps; 0: the meshes' mean edge, 5 mm at least
    double normal_scale_m = 0.0;  // over which the ground's normal is taken; 0: 8 cells
    double cylinder_m = 0.0;      // diameter over which points are averaged, more on ground that is
                                  // too coarse for it; 0: 4 cells
    double reach_m = 0.6;         // larger changes are measured along the vertical only
    double least_area_m2 = 0.0;   // of a patch; 0: four cross-sections of the cylinder
};

struct CompareRequest {
    std::filesystem::path a;    // folder of the earlier reconstruction
    std::filesystem::path b;    // of the later one
    std::filesystem::path out;  // created if missing
    // areas.json, each in the frame of the reconstruction that it is drawn on; without the later
    // one, the earlier outlines apply to both.
    std::optional<std::filesystem::path> areas;
    std::optional<std::filesystem::path> later_areas;
    CompareOptions options;
    int num_threads = 0;  // 0: all cores; never changes a byte of the result
    std::uint64_t seed = 1;
};

// Compares two dives of one place. It aligns b with a (markers, features or geometry, then stable
// surface), measures M3C2 distances with their level of detection, and gathers significant change
// that both dives could see into patches with volumes and 95 % intervals. It writes compare.json
// (schemas/compare.schema.json), report.html, changed_mesh.ply (b coloured by change, with the
// distances), mosaic_difference.png and .json, change_height.png, and with areas area_changes.csv
// into `out`; returns compare.json. The result does not depend on the number of threads. Stages of
// the progress: register, measure, change, write. Of a dive in several tracking segments only the
// largest is compared. Throws Error{NotFound} or Error{BadData} for folders that are not
// reconstructions with a surface or whose segments cannot be told apart, Error{Conflict} if the two
// cannot be aligned (different places, too little overlap, ambiguous ground),
// Error{InvalidArgument} for options out of range.
nlohmann::json compare_reconstructions(
    const CompareRequest& request, const base::ProgressCallback& report = base::ignore_progress);

}  // namespace divemesh::compare
