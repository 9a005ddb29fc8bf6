#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "worker/io/reconstruction_folder.hpp"
#include "worker/reef/import_areas.hpp"
#include "worker/reef/measure_areas.hpp"

namespace divemesh::reef {

// Returns options with the reconstruction's own resolution (positions of the body, focal length of
// the images in which the surface was matched, voxels) and shared errors (poses, scale).
MeasureOptions measure_options(const io::ReconstructionFolder& reconstruction);

// Returns areas in the world frame. Areas in the ground truth's frame are transformed by the SE(3)
// that aligns the reconstruction's poses with the true ones (T_reference_surface). Throws
// Error{InvalidArgument} if the areas need a ground truth and there is none.
AreaSet areas_in_world(const AreaSet& set,
                       const types::Trajectory& estimate,
                       const std::optional<types::Trajectory>& ground_truth);

struct MeasureRequest {
    std::filesystem::path reconstruction;  // folder
    // areas.json or another program's file; nullopt: only the whole model
    std::optional<std::filesystem::path> areas;
    std::optional<std::filesystem::path> ground_truth;  // trajectory, TUM or EuRoC
    int num_threads = 0;
    AreaImport area_import;  // how another program's file is read
};

// Runs `divemesh measure`; returns what measure_areas() returns, with "reconstruction": {verdict?,
// restrictions?, findings} as metrics.json states them, of the findings those that restrict scale,
// surface, accuracy or all.
nlohmann::json measure_reconstruction(const MeasureRequest& request);

// Returns a header and a row per metric: figure, area, label, unit, resolution_m, value, low, high,
// method, refused (RFC 4180; lines end with \n).
std::string metrics_csv(const nlohmann::json& metrics);
// Writes that table to a file.
void write_metrics_csv(const nlohmann::json& metrics, const std::filesystem::path& path);

}  // namespace divemesh::reef
