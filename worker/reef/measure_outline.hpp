#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "worker/reef/area_plane.hpp"
#include "worker/reef/measure_options.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::reef {

// The names of an area to be measured.
struct AreaTask {
    std::string name;
    std::string label;
    std::string kind;
    bool is_whole_model = false;  // has no outline: the seen ground is the area
};

// The result of one area.
struct AreaResult {
    nlohmann::json area;                               // an entry of measure_areas()
    nlohmann::json metrics = nlohmann::json::array();  // entries of measure_areas()
    double planar_m2 = 0.0;                            // of the outline; whole model: as seen
    double border_sigma_m2 = 0.0;                      // sigma of the whole model's planar_m2
    double coverage = 0.0;
    double noise_share = 1.0;  // shown share of the stated local sigma (NoiseLevel)
};

// Measures the ground within an outline.
AreaResult measure_outline(const types::Mesh& mesh,
                           const AreaTask& task,
                           const AreaPlane& plane,
                           const MeasureOptions& options);

// Measures along a transect: the chain's length over the line's, at each spacing.
AreaResult measure_transect(const types::Mesh& mesh,
                            const AreaTask& task,
                            const std::vector<Eigen::Vector3d>& line,
                            const Eigen::Vector3d& normal,
                            const MeasureOptions& options);

}  // namespace divemesh::reef
