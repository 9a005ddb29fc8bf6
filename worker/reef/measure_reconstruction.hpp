#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "worker/io/reconstruction_folder.hpp"
#include "worker/reef/measure_areas.hpp"

namespace divemesh::reef {

// What a reconstruction says of its own fineness: where the body was, focal length, voxels.
MeasureOptions measure_options(const io::ReconstructionFolder& reconstruction);

// Areas in the ground truth's frame, moved by the SE(3) that lays the reconstruction's poses on the
// true ones (T_reference_surface); those in the world's as they are. Throws Error{InvalidArgument}
// when the areas need a ground truth and there is none.
AreaSet areas_in_world(const AreaSet& set,
                       const types::Trajectory& estimate,
                       const std::optional<types::Trajectory>& ground_truth);

struct MeasureRequest {
    std::filesystem::path reconstruction;        // folder
    std::optional<std::filesystem::path> areas;  // areas.json; nothing: the whole model alone
    std::optional<std::filesystem::path> ground_truth;  // trajectory, TUM or EuRoC
    int num_threads = 0;
};

// `divemesh measure`: as measure_areas answers.
nlohmann::json measure_reconstruction(const MeasureRequest& request);

// A heading and a row per figure: figure, area, label, unit, resolution_m, value, low, high,
// method, refused (RFC 4180; lines end with \n).
std::string metrics_csv(const nlohmann::json& metrics);

}  // namespace divemesh::reef
