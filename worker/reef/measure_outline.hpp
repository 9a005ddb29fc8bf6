#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "worker/reef/area_plane.hpp"
#include "worker/reef/measure_options.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::reef {

struct AreaTask {
    std::string name;
    std::string label;
    std::string kind;
    bool is_whole_model = false;  // no outline of its own: what was seen is the area
};

struct AreaResult {
    nlohmann::json area;                               // as measure_areas answers it
    nlohmann::json metrics = nlohmann::json::array();  // likewise
    double planar_m2 = 0.0;                            // of the outline; the whole: what was seen
    double border_sigma_m2 = 0.0;                      // what planar_m2 of the whole errs by
    double coverage = 0.0;
    double noise_share = 1.0;  // of the stated local sigma, what the surface shows (NoiseLevel)
};

// The figures over the ground within an outline.
AreaResult measure_outline(const types::Mesh& mesh,
                           const AreaTask& task,
                           const AreaPlane& plane,
                           const MeasureOptions& options);

// Along a transect: the chain's length over the line's, at each spacing.
AreaResult measure_transect(const types::Mesh& mesh,
                            const AreaTask& task,
                            const std::vector<Eigen::Vector3d>& line,
                            const Eigen::Vector3d& normal,
                            const MeasureOptions& options);

}  // namespace divemesh::reef
